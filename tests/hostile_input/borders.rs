//! What holds and pushes bodies.
use super::{GOOD, refused};

/// What would do nothing, or two things at once, is refused.
#[test]
fn what_holds_and_pushes() {
    let add = |text: &str| GOOD.replace("[run]", &format!("{text}\n[run]"));
    for (text, facts) in [
        ("[[drive]]\nmaterial = \"hard\"", &["is rigid", "prescribed"][..]),
        ("[[drive]]\nmaterial = \"soft\"\nbody = \"blok\"", &["no body \"blok\"", "did you mean `block`"]),
        ("[[drive]]\nmaterial = \"soft\"\nbody = \"tool\"", &["made of \"hard\""]),
        (
            "[[drive]]\nmaterial = \"soft\"\nregion = { sphere = { center = [1, 1, 1], radius = 0.01 } }",
            &["no particle of \"soft\"", "region"],
        ),
        (
            "[[drive]]\nmaterial = \"soft\"\nvelocity = [0, 0, 0]\ndisplacement = [0, 0, 0]",
            &["both `velocity` and `displacement`"],
        ),
        ("[[drive]]\nmaterial = \"soft\"\ncomponents = \"zx\"", &["components", "did you mean `x"]),
        ("[[force]]\nmaterial = \"soft\"", &["one of `total`, `traction` and `pressure`"]),
        ("[[force]]\nmaterial = \"soft\"\npressure = \"1 N\"", &["is a stress", "a force"]),
        ("[[force]]\nmaterial = \"soft\"\npressure = [[0, 1, 2]]", &["a row [time, number]"]),
        ("[[force]]\nmaterial = \"hard\"\ntotal = [1, 0, 0]", &["is rigid"]),
        ("[[force]]\nmaterial = \"soft\"\ntotal = [1, 0, 0]\nside = \"+x\"", &["side", "a total"]),
        ("[[force]]\nmaterial = \"soft\"\ntraction = [1, 0, 0]\nfollows = false", &["follows", "direction"]),
        ("[load]\nlocal-damping = 1", &["load.local-damping", "at most 0.95"]),
    ] {
        let (error, _) = refused(&add(text), &[]);
        assert!(facts.iter().all(|fact| error.contains(fact)), "{text}: {error}");
    }
    let (error, _) = refused(
        &GOOD.replacen(
            "[[body]]",
            "[material.more]\nlaw = \"rigid\"\ndensity = 1\nmotion = \"free\"\n[[body]]",
            1,
        ),
        &[],
    );
    assert!(error.contains("\"more\" has no body"), "{error}");
    let tool = GOOD
        .replace("motion = \"free\"", "motion = \"prescribed\"")
        .replace("velocity = [\"-1 m/s\", 0, 0]\n", "");
    let only = tool
        .replace("material = \"soft\"", "material = \"hard\"")
        .replace("fibers = { uniform = [0, 2, 0] }\n", "");
    let (error, _) = refused(&only, &[]);
    assert!(error.contains("tools and no matter"), "{error}");
    let turning = tool
        .replace("radius = \"15 mm\"", "radius = \"1 m\"")
        .replace("motion = ", "angular-velocity = [0, 0, 1]\nmotion = ");
    let (error, _) = refused(&turning, &[]);
    assert!(error.contains("about what does it turn"), "{error}");
}
