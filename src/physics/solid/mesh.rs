//! Solids within a closed surface of triangles.
use super::distance::Distance;
use super::{Bounds, cross, direction, dot, sub};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::Arc;

/// A closed surface of triangles, and what lies within. Copies share it.
#[derive(Clone)]
pub struct Mesh(Arc<TriMesh>);

/// Why triangles do not bound a solid.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshError {
    /// There are none, or some coordinate is not a number.
    Nothing,
    /// A triangle has no area.
    Flat([[f64; 3]; 3]),
    /// The edge between two points belongs to one triangle alone, or to more than two.
    Open([[f64; 3]; 2]),
    /// Two triangles that share the edge between two points do not agree where outside is.
    Twisted([[f64; 3]; 2]),
    /// It points inwards.
    InsideOut,
    /// Two of its shells may overlap: the boxes around them do.
    Shells,
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeshError::Nothing => write!(f, "it has no triangles, or some coordinate is not a number"),
            MeshError::Flat([a, b, c]) => write!(f, "the triangle {a:?}, {b:?}, {c:?} m has no area"),
            MeshError::Open([a, b]) => {
                write!(f, "it is not closed: not just two triangles share the edge from {a:?} to {b:?} m")
            }
            MeshError::Twisted([a, b]) => {
                write!(f, "the triangles at the edge from {a:?} to {b:?} m do not agree where outside is")
            }
            MeshError::Shells => write!(
                f,
                "it has several closed shells, and the boxes around two of them overlap: give each a file of its own, and join them by \
                 `union` or `difference`"
            ),
            MeshError::InsideOut => {
                write!(f, "its triangles turn clockwise as seen from outside: it is inside out")
            }
        }
    }
}

impl Mesh {
    /// The solid within triangles whose corners [m] go counterclockwise as seen from outside. Corners at the same place are one. That
    /// the surface does not cut itself is not checked.
    ///
    /// # Errors
    /// What keeps them from bounding a solid.
    pub fn new(triangles: &[[[f64; 3]; 3]]) -> Result<Self, MeshError> {
        let (mut points, mut known): (Vec<[f64; 3]>, HashMap<[u64; 3], u32>) = Default::default();
        let mut corners = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            if triangle.as_flattened().iter().any(|x| !x.is_finite()) {
                return Err(MeshError::Nothing);
            }
            corners.push(triangle.map(|x| {
                // 0 and −0 are the same place
                *known.entry(x.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                    points.push(x);
                    points.len() as u32 - 1
                })
            }));
        }
        closed(&points, &corners)?;
        apart(&points, &corners)?;
        let volume: f64 = triangles.iter().map(|[a, b, c]| dot(*a, cross(*b, *c))).sum();
        if volume <= 0.0 {
            return Err(MeshError::InsideOut);
        }
        let points = points.into_iter().map(|[x, y, z]| Vector::new(x, y, z)).collect();
        let mesh = TriMesh::with_flags(points, corners, TriMeshFlags::ORIENTED);
        mesh.map(|mesh| Self(Arc::new(mesh))).map_err(|_| MeshError::Nothing)
    }

    /// Whether a point [m] lies inside.
    pub fn contains(&self, [x, y, z]: [f64; 3]) -> bool {
        self.0.local_aabb().contains_local_point(Vector::new(x, y, z))
            && self.0.contains_local_point(Vector::new(x, y, z))
    }

    /// The box around it [m].
    pub fn bounds(&self) -> Bounds {
        let all = self.0.local_aabb();
        (all.mins.into(), all.maxs.into())
    }

    /// Signed distance [m], exact.
    pub fn distance(&self, x: [f64; 3]) -> Distance {
        let (nearest, feature) =
            self.0.project_local_point_and_get_location(Vector::new(x[0], x[1], x[2]), false);
        let away = sub(x, nearest.point.into());
        let (length, sign) = (dot(away, away).sqrt(), if nearest.is_inside { -1.0 } else { 1.0 });
        let (lower, upper) = self.bounds();
        // on the surface, the difference of two points has no direction
        let normal = match length > 1e-12 * dot(sub(upper, lower), sub(upper, lower)).sqrt() {
            true => away.map(|a| sign * a / length),
            false => self.face(feature.0),
        };
        (sign * length, normal)
    }

    /// The normal of a triangle.
    fn face(&self, triangle: u32) -> [f64; 3] {
        let triangle = self.0.triangle(triangle);
        let [a, b, c]: [[f64; 3]; 3] = [triangle.a.into(), triangle.b.into(), triangle.c.into()];
        direction(cross(sub(b, a), sub(c, a))).unwrap_or([0.0, 0.0, 1.0])
    }
}

/// Whether each edge belongs to two triangles, which pass it in opposite directions.
fn closed(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Nothing);
    }
    let mut passed: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
    let at = |corner: u32| points[corner as usize];
    for &[a, b, c] in triangles {
        let n = cross(sub(at(b), at(a)), sub(at(c), at(a)));
        if dot(n, n) == 0.0 {
            return Err(MeshError::Flat([at(a), at(b), at(c)]));
        }
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let counts = passed.entry([from.min(to), from.max(to)]).or_default();
            counts[usize::from(from > to)] += 1;
        }
    }
    let mut edges: Vec<_> = passed.into_iter().filter(|(_, counts)| *counts != [1, 1]).collect();
    edges.sort_unstable();
    match edges.first() {
        None => Ok(()),
        Some((edge, [2, 0] | [0, 2])) => Err(MeshError::Twisted(edge.map(at))),
        Some((edge, _)) => Err(MeshError::Open(edge.map(at))),
    }
}

/// Whether the shells of a closed surface lie apart: the boxes around them do not overlap.
fn apart(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    let mut root: Vec<u32> = (0..points.len() as u32).collect();
    fn find(root: &mut [u32], mut corner: u32) -> u32 {
        while root[corner as usize] != corner {
            root[corner as usize] = root[root[corner as usize] as usize];
            corner = root[corner as usize];
        }
        corner
    }
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (one, other) = (find(&mut root, a), find(&mut root, other));
            root[one.max(other) as usize] = one.min(other);
        }
    }
    let mut boxes: BTreeMap<u32, Bounds> = BTreeMap::new();
    for (corner, x) in points.iter().enumerate() {
        let shell = find(&mut root, corner as u32);
        let known = boxes.entry(shell).or_insert((*x, *x));
        *known = super::hull(*known, (*x, *x));
    }
    let boxes: Vec<Bounds> = boxes.into_values().collect();
    let overlap = |(one, other): (&Bounds, &Bounds)| {
        let (lower, upper) = super::overlap(*one, *other);
        (0..3).all(|a| lower[a] < upper[a])
    };
    let pairs =
        boxes.iter().enumerate().flat_map(|(n, one)| boxes[n + 1..].iter().map(move |other| (one, other)));
    if pairs.into_iter().any(overlap) { Err(MeshError::Shells) } else { Ok(()) }
}

impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        let same = || self.0.vertices() == other.0.vertices() && self.0.indices() == other.0.indices();
        Arc::ptr_eq(&self.0, &other.0) || same()
    }
}

impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Mesh of {} triangles", self.0.indices().len())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Solid;
    use super::*;

    /// The faces of a box, counterclockwise from outside.
    fn faces(lower: [f64; 3], upper: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
        let corner = |c: [usize; 3]| [0, 1, 2].map(|a| [lower, upper][c[a]][a]);
        let mut all = Vec::new();
        for (a, end) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let at = |u: usize, v: usize| {
                let mut of = [0; 3];
                (of[a], of[b], of[c]) = (end, u, v);
                corner(of)
            };
            let ring = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let [p, q, r, s] = if end == 1 { ring } else { [ring[0], ring[3], ring[2], ring[1]] };
            all.extend([[p, q, r], [p, r, s]]);
        }
        all
    }

    const LOWER: [f64; 3] = [-0.5, 0.0, -1.0];
    const UPPER: [f64; 3] = [0.5, 0.3, 0.25];

    #[test]
    fn a_box_of_triangles_is_the_box() {
        let mesh = Mesh::new(&faces(LOWER, UPPER)).expect("closed");
        let exact = Solid::Box { lower: LOWER, upper: UPPER };
        assert_eq!(mesh.bounds(), (LOWER, UPPER));
        let mut place = [0.123, 0.456, 0.789];
        for n in 0..5000 {
            place = place.map(|x: f64| (x * 7.31 + 0.177).fract());
            let x: [f64; 3] = std::array::from_fn(|a| 2.5 * (place[a] - 0.5) + 0.2);
            let ((distance, normal), (wanted, toward)) = (mesh.distance(x), exact.distance(x));
            assert!((distance - wanted).abs() < 1e-12, "{n}: {x:?} {distance} {wanted}");
            assert_eq!(mesh.contains(x), wanted < 0.0);
            // where two faces are as near, both normals are right
            let agrees = dot(normal, toward) > 1.0 - 1e-9;
            assert!(agrees || wanted < 0.0, "{x:?} {normal:?} {toward:?}");
        }
        // on the surface the face says where outside is
        let (distance, normal) = mesh.distance([0.1, 0.3, 0.0]);
        assert!(distance.abs() < 1e-15 && normal == [0.0, 1.0, 0.0], "{distance:e} {normal:?}");
    }

    #[test]
    fn what_bounds_no_solid_is_refused() {
        let all = faces(LOWER, UPPER);
        assert_eq!(Mesh::new(&[]), Err(MeshError::Nothing));
        assert!(matches!(Mesh::new(&all[1..]), Err(MeshError::Open(_))));
        let turned: Vec<_> = all.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert_eq!(Mesh::new(&turned), Err(MeshError::InsideOut));
        let mut one = all.clone();
        one[3].swap(1, 2);
        assert!(matches!(Mesh::new(&one), Err(MeshError::Twisted(_))));
        let mut flat = all.clone();
        flat[3][2] = flat[3][1];
        assert!(matches!(Mesh::new(&flat), Err(MeshError::Flat(_))));
        let mut nan = all.clone();
        nan[0][0][0] = f64::NAN;
        assert_eq!(Mesh::new(&nan), Err(MeshError::Nothing));
        // boxes apart are one solid, boxes that overlap or lie within one another are not
        let two = |lower, upper| Mesh::new(&[all.clone(), faces(lower, upper)].concat());
        assert!(two([0.6, 0.0, -1.0], [1.0, 0.3, 0.25]).is_ok());
        assert_eq!(two([0.4, 0.1, -0.5], [1.0, 0.4, 0.5]), Err(MeshError::Shells));
        assert_eq!(two([-0.4, 0.1, -0.5], [0.4, 0.2, 0.1]), Err(MeshError::Shells));
        // two boxes that share an edge
        let twice = [all, faces([0.5, 0.3, -1.0], [1.0, 1.0, 0.25])].concat();
        assert!(matches!(Mesh::new(&twice), Err(MeshError::Open(_))));
    }
}
