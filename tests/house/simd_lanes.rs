//! Every vector does in each lane what its documentation says, bit for bit, on every instruction set.
use crate::common::{Random, instruction_sets};
use simd::{Isa, Job, LANES, Mask, Simd, Wide};

type Line = [f64; LANES];

/// Lines, and what each operation makes of them.
struct Operations<'a>(&'a [[Line; 3]]);

/// Names and results, in the order of `expected`.
type Results = Vec<(&'static str, Line)>;

impl Job for Operations<'_> {
    type Output = Vec<Results>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Results> {
        let mut all = Vec::new();
        for [a, b, c] in self.0 {
            let [a, b, c] = [a, b, c].map(|line| S::load(&Wide(*line)));
            let (zero, one) = (S::splat(0.0), S::splat(1.0));
            let upper = |t: S::Upper| zero.fma_upper(zero, t);
            let (yes, finite) = (a.ge(b), S::select(b.abs().lt(S::splat(f64::INFINITY)), b, one));
            let results = [
                ("splat", S::splat(1.5)),
                ("add", a + b),
                ("sub", a - b),
                ("mul", a * b),
                ("div", a / b),
                ("neg", -a),
                ("sqrt", a.sqrt()),
                ("max", a.max(b)),
                ("min", a.min(b)),
                ("abs", a.abs()),
                ("floor", a.floor()),
                ("round", a.round()),
                ("ge", bits(yes)),
                ("lt", bits(a.lt(b))),
                ("differs", bits(a.differs(b))),
                ("select", S::select(yes, a, c)),
                ("blend_force", S::blend_force(a, b)),
                ("force", upper(a.force())),
                ("low_to_force", upper(a.low_to_force())),
                ("times_upper", upper(finite.times_upper(a.force()))),
                ("upper sum", upper(a.force() + b.low_to_force() - c.force())),
                ("momentum_to_low", a.momentum_to_low()),
                ("swap_halves", a.swap_halves()),
                ("join_low", S::join_low(a, b)),
                ("with_3_7", a.with_3_7(b)),
                ("with_3", a.with_3(b)),
            ];
            all.push(results.map(|(name, x)| (name, x.lanes())).to_vec());
        }
        all
    }
}

/// A mask as numbers.
#[inline(always)]
fn bits<S: Simd>(mask: Mask) -> S {
    S::load(&Wide(std::array::from_fn(|i| f64::from(mask >> i & 1))))
}

fn lanes(f: impl Fn(usize) -> f64) -> Line {
    std::array::from_fn(f)
}

/// The same by the words of the documentation.
fn expected([a, b, c]: &[Line; 3]) -> Results {
    let forces = 4..7;
    let truth = |f: fn(&f64, &f64) -> bool| lanes(|i| f64::from(u8::from(f(&a[i], &b[i]))));
    let force = |x: &Line| lanes(|i| if forces.contains(&i) { x[i] } else { 0.0 });
    let low_to_force = |x: &Line| lanes(|i| if forces.contains(&i) { x[i - 4] } else { 0.0 });
    // a sum that begins with nothing has no negative zero
    let upper = |x: Line| x.map(|x| 0.0 + x);
    vec![
        ("splat", [1.5; LANES]),
        ("add", lanes(|i| a[i] + b[i])),
        ("sub", lanes(|i| a[i] - b[i])),
        ("mul", lanes(|i| a[i] * b[i])),
        ("div", lanes(|i| a[i] / b[i])),
        ("neg", lanes(|i| -a[i])),
        ("sqrt", lanes(|i| a[i].sqrt())),
        ("max", lanes(|i| if a[i] > b[i] { a[i] } else { b[i] })),
        ("min", lanes(|i| if a[i] < b[i] { a[i] } else { b[i] })),
        ("abs", lanes(|i| a[i].abs())),
        ("floor", lanes(|i| a[i].floor())),
        ("round", lanes(|i| a[i].round_ties_even())),
        ("ge", truth(f64::ge)),
        ("lt", truth(f64::lt)),
        ("differs", truth(f64::ne)),
        ("select", lanes(|i| if a[i] >= b[i] { a[i] } else { c[i] })),
        ("blend_force", lanes(|i| if forces.contains(&i) { b[i] } else { a[i] })),
        ("force", upper(force(a))),
        ("low_to_force", upper(low_to_force(a))),
        ("times_upper", {
            let finite = b.map(|b| if b.is_finite() { b } else { 1.0 });
            upper(lanes(|i| finite[i] * force(a)[i]))
        }),
        ("upper sum", {
            let (f, g, h) = (force(a), low_to_force(b), force(c));
            upper(lanes(|i| f[i] + g[i] - h[i]))
        }),
        ("momentum_to_low", [a[1], a[2], a[3], 0.0, a[4], a[5], a[6], 0.0]),
        ("swap_halves", lanes(|i| a[(i + 4) % 8])),
        ("join_low", lanes(|i| if i < 4 { a[i] } else { b[i - 4] })),
        ("with_3_7", lanes(|i| [b[0], b[1]].get(i / 4).filter(|_| i % 4 == 3).copied().unwrap_or(a[i]))),
        ("with_3", lanes(|i| if i == 3 { b[2] } else { a[i] })),
    ]
}

/// Numbers of all sizes and signs, with those that are special in every lane.
fn lines() -> Vec<[Line; 3]> {
    let special = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.5, -2.5, 3.0, 1e-310, 4e300];
    let mut random = Random(1);
    let mut next = || match random.within(0.0, 4.0) as i32 {
        0 => special[random.within(0.0, special.len() as f64) as usize],
        n => random.within(-5.0, 5.0) * 10f64.powi(4 * n - 8),
    };
    (0..4000).map(|_| std::array::from_fn(|_| std::array::from_fn(|_| next()))).collect()
}

/// What is no number is the same whatever its bits.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

#[test]
fn every_lane_is_what_the_documentation_says() {
    let lines = lines();
    for isa in sets() {
        for (input, results) in lines.iter().zip(isa.dispatch(Operations(&lines))) {
            for ((name, got), (wanted_name, wanted)) in results.into_iter().zip(expected(input)) {
                assert_eq!(name, wanted_name);
                let right = (0..LANES).all(|i| same(got[i], wanted[i]));
                assert!(right, "{isa:?} {name}: {got:?}, not {wanted:?}, of {input:?}");
            }
        }
    }
}

struct Fused<'a>(&'a [[Line; 3]]);

impl Job for Fused<'_> {
    type Output = Vec<[Line; 4]>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<[Line; 4]> {
        let mut all = Vec::new();
        for [a, b, c] in self.0 {
            let [a, b, c] = [a, b, c].map(|line| S::load(&Wide(*line)));
            let upper = a.fma_upper(b, c.force());
            all.push([a.fma(b, c), a.fms(b, c), a.fnma(b, c), upper].map(|x| x.lanes()));
        }
        all
    }
}

#[test]
fn sums_of_products_are_rounded_once_where_the_set_can() {
    let lines = lines();
    for isa in sets() {
        let fused = ![Isa::BASELINE, Isa::COUNTING].contains(&isa);
        let add = |a: f64, b: f64, c: f64| if fused { a.mul_add(b, c) } else { a * b + c };
        for ([a, b, c], results) in lines.iter().zip(isa.dispatch(Fused(&lines))) {
            for i in 0..LANES {
                let force = if (4..7).contains(&i) { c[i] } else { 0.0 };
                let wanted = [
                    add(a[i], b[i], c[i]),
                    add(a[i], b[i], -c[i]),
                    add(-a[i], b[i], c[i]),
                    add(a[i], b[i], force),
                ];
                for (kind, (result, wanted)) in results.iter().zip(wanted).enumerate() {
                    // a product that is not added to anything may keep the sign of its zero
                    let right = same(result[i], wanted) || kind == 3 && result[i] == wanted;
                    assert!(
                        right,
                        "{isa:?} {kind}: {} is not {wanted}, of {} {} {}",
                        result[i], a[i], b[i], c[i]
                    );
                }
            }
        }
    }
}

struct Exponents<'a>(&'a [Line]);

impl Job for Exponents<'_> {
    type Output = Vec<[Line; 3]>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<[Line; 3]> {
        let mut all = Vec::new();
        for x in self.0 {
            let (m, e) = S::load(&Wide(*x)).split_exponent();
            // back in two steps: the exponent of what is nearly too large is too large for one
            let half = (e * S::splat(0.5)).floor();
            let back = m.scale_exponent(half).scale_exponent(e - half);
            all.push([m, e, back].map(|x| x.lanes()));
        }
        all
    }
}

#[test]
fn exponents_are_split_off_and_put_back() {
    let number = |i: usize| f64::from_bits(0x0010_0000_0000_0000 + 0x0002_6F3C_5A77_1234 * i as u64);
    let lines: Vec<Line> = (0..1500).map(|n| lanes(|i| number(8 * n + i))).collect();
    assert!(lines.as_flattened().iter().all(|x| x.is_normal() && *x > 0.0));
    for isa in sets() {
        for (x, [m, e, back]) in lines.iter().zip(isa.dispatch(Exponents(&lines))) {
            for i in 0..LANES {
                assert!(
                    (0.5f64.sqrt()..2f64.sqrt()).contains(&m[i]),
                    "{isa:?}: {} = {} 2^{}",
                    x[i],
                    m[i],
                    e[i]
                );
                assert_eq!((back[i], e[i].fract()), (x[i], 0.0), "{isa:?}");
            }
        }
    }
}

struct Transposed([Line; LANES]);

impl Job for Transposed {
    type Output = [Line; LANES];
    #[inline(always)]
    fn run<S: Simd>(self) -> [Line; LANES] {
        S::transpose(self.0.map(|line| S::load(&Wide(line)))).map(|x| x.lanes())
    }
}

#[test]
fn rows_become_lanes() {
    let rows: [Line; LANES] = std::array::from_fn(|j| lanes(|i| (10 * j + i) as f64));
    for isa in sets() {
        assert_eq!(isa.dispatch(Transposed(rows)), std::array::from_fn(|j| lanes(|i| rows[i][j])), "{isa:?}");
    }
}

/// All of this machine, and the one that counts.
fn sets() -> Vec<Isa> {
    [instruction_sets(), vec![Isa::COUNTING]].concat()
}
