//! Wounds of known size in made slabs, measured.
use sinew::lab::wound::{Passage, Report, Scale, Tissue, code, measure_tissue};

const MM: f64 = 1e-3;
const SCALE: Scale = Scale { thickness: 10.0 * MM, spacing: 0.4 * MM, caliber: 9.0 * MM };

/// A slab of 40 x 40 x 10 mm; `failure` of a place (lateral, depth), `None` where it is drilled away.
fn slab(failure: impl Fn([f64; 3]) -> Option<u8>) -> Tissue {
    let mut tissue = Tissue::default();
    let h = SCALE.spacing;
    let at = |i: usize, low: f64| low + (i as f64 + 0.5) * h;
    for k in 0..25 {
        for j in 0..100 {
            for i in 0..100 {
                let x = [at(i, -20.0 * MM), at(j, -20.0 * MM), at(k, 0.0)];
                if let Some(kind) = failure(x) {
                    tissue.now.push(x);
                    tissue.start.push(x);
                    tissue.failure.push(kind);
                }
            }
        }
    }
    tissue
}

fn radius(x: [f64; 3]) -> f64 {
    x[0].hypot(x[1])
}

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected} within {tolerance}");
}

#[test]
fn a_drilled_cylinder_has_its_diameter_at_every_depth() {
    for diameter in [6.0 * MM, 12.0 * MM, 25.0 * MM] {
        let report = measure_tissue(&slab(|x| (radius(x) > 0.5 * diameter).then_some(code::NONE)), SCALE);
        for layer in &report.layers {
            close(layer.cavity_m, diameter, 0.3 * MM);
            close(layer.cavity.unwrap().ratio, 1.0, 0.03);
            close(layer.failed_layer_m, layer.cavity_m, 0.3 * MM);
        }
        close(report.taper, 0.0, 1e-3);
        assert_eq!(report.failed_fraction.any, 0.0);
        assert!(report.to_string().contains("Nothing failed."));
    }
}

#[test]
fn a_cone_has_its_taper() {
    let wall = |x: [f64; 3]| 0.5 * (10.0 * MM + 0.8 * x[2]);
    let report = measure_tissue(&slab(|x| (radius(x) > wall(x)).then_some(code::NONE)), SCALE);
    close(report.entry_m, 10.3 * MM, 0.6 * MM);
    close(report.exit_m, 17.7 * MM, 0.6 * MM);
    close(report.taper, 0.8, 0.05);
    assert!(report.cavity_m[0] < report.cavity_m[1]);
}

#[test]
fn an_ellipse_has_its_axes_and_its_angle() {
    let angle = 30f64.to_radians();
    let inside = |x: [f64; 3], scale: f64| {
        let u = x[0] * angle.cos() + x[1] * angle.sin();
        let v = x[1] * angle.cos() - x[0] * angle.sin();
        (u / (8.0 * MM * scale)).hypot(v / (5.0 * MM * scale)) < 1.0
    };
    let kind = |x| if inside(x, 1.3) { code::FIBER } else { code::NONE };
    let report = measure_tissue(&slab(|x| (!inside(x, 1.0)).then(|| kind(x))), SCALE);
    for ellipse in [report.exit_cavity.unwrap(), report.exit_failed.unwrap()] {
        close(ellipse.ratio, 1.6, 0.12);
        close(ellipse.angle_deg, 30.0, 3.0);
    }
    close(report.exit_m, 2.0 * 40f64.sqrt() * MM, 0.3 * MM);
}

#[test]
fn shells_around_the_hole_are_layer_and_reach() {
    // Hole to 6 mm, failed to 9, intact to 12, failed to 14 (radii).
    let kind = |x: [f64; 3]| match radius(x) / MM {
        r if r < 6.0 => None,
        r if r < 9.0 => Some(code::TOTAL),
        r if r < 12.0 => Some(code::NONE),
        r if r < 14.0 => Some(code::MATRIX),
        _ => Some(code::NONE),
    };
    let report = measure_tissue(&slab(kind), SCALE);
    close(report.cavity_m[1], 12.0 * MM, 0.3 * MM);
    close(report.failed_layer_m[1], 18.0 * MM, 0.4 * MM);
    close(report.failed_reach_m[1], 27.5 * MM, 0.6 * MM);
    let failed = report.failed_fraction;
    let whole = 1600.0 - 36.0 * std::f64::consts::PI;
    close(failed.total, 45.0 * std::f64::consts::PI / whole, 0.004);
    close(failed.matrix, 52.0 * std::f64::consts::PI / whole, 0.004);
    close(failed.any, failed.total + failed.matrix, 1e-12);
}

#[test]
fn spray_and_flying_pieces_do_not_fill_the_hole() {
    let clean = slab(|x| (radius(x) > 6.0 * MM).then_some(code::TOTAL));
    let mut tissue = clean.clone();
    // Failed grains that flew far, some of which lie inside the hole, and an intact plug ahead of the slab.
    for i in 0..3000u32 {
        let [a, b, c] = [7919, 104_729, 1_299_709].map(|p| f64::from(i.wrapping_mul(p) % 1000) / 1000.0);
        let start = [(a - 0.5) * 8.0 * MM, (b - 0.5) * 8.0 * MM, c * 10.0 * MM];
        tissue.start.push(start);
        tissue.now.push([start[0], start[1], start[2] + 12.0 * MM]);
        tissue.failure.push(code::TOTAL);
        tissue.start.push(start);
        tissue.now.push([start[0], start[1], start[2] + 30.0 * MM]);
        tissue.failure.push(code::NONE);
    }
    let report = measure_tissue(&tissue, SCALE);
    let reference = measure_tissue(&clean, SCALE);
    assert_eq!(report.cavity_m, reference.cavity_m);
    close(report.loose_fraction, 6000.0 / tissue.now.len() as f64, 1e-12);
}

#[test]
fn a_stretched_slab_is_not_a_hole_and_a_moved_hole_is_found() {
    let mut tissue = slab(|_| Some(code::NONE));
    tissue.now.iter_mut().for_each(|x| *x = [1.5 * x[0], x[1], x[2]]);
    assert_eq!(measure_tissue(&tissue, SCALE).cavity_m, [0.0, 0.0]);

    let away = |x: [f64; 3]| (x[0] - 3.0 * MM).hypot(x[1] + 2.0 * MM);
    let report = measure_tissue(&slab(|x| (away(x) > 5.0 * MM).then_some(code::NONE)), SCALE);
    close(report.exit_m, 10.0 * MM, 0.3 * MM);
    let center = report.exit_cavity.unwrap().center_m;
    close(center[0], 3.0 * MM, 0.2 * MM);
    close(center[1], -2.0 * MM, 0.2 * MM);
}

#[test]
fn nothing_happened_and_nothing_there() {
    let report = measure_tissue(&slab(|_| Some(code::NONE)), SCALE);
    assert_eq!((report.entry_m, report.exit_m, report.taper), (0.0, 0.0, 0.0));
    assert_eq!((report.exit_cavity, report.exit_failed), (None, None));
    let empty: Report = measure_tissue(&Tissue::default(), SCALE);
    assert_eq!(empty.failed_layer_m, [0.0, 0.0]);
    assert!(empty.to_string().contains("entry diameter"));
}

#[test]
fn an_unfinished_shot_says_so_and_json_has_every_layer() {
    let mut report = measure_tissue(&slab(|x| (radius(x) > 5.0 * MM).then_some(code::NONE)), SCALE);
    report.passage = Passage::Inside { tip_m: 7.0 * MM, tail_m: -2.0 * MM };
    let text = report.to_string();
    assert!(text.contains("has not left: tip at depth 7.00 mm"), "{text}");
    assert!(text.contains("16-19 mm"), "{text}");
    let json = report.json();
    assert_eq!(json["passage"]["state"], "inside");
    assert_eq!(json["layers"].as_array().unwrap().len(), report.layers.len());
    assert_eq!(json["entry_m"], report.entry_m);
}
