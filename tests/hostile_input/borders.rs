//! What holds and pushes bodies.
use super::{GOOD, refused};
use sinew::input::read_text;

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
        (
            "[[drive]]\nmaterial = \"soft\"\ndisplacement = [[0, 0, 0, 0.001], [1, 0, 0, 0]]",
            &["zero there", "begin the table"],
        ),
        ("[[drive]]\nmaterial = \"soft\"\ncomponents = \"zx\"", &["components", "did you mean `x"]),
        ("[[force]]\nmaterial = \"soft\"", &["one of `total`, `traction` and `pressure`"]),
        ("[[force]]\nmaterial = \"soft\"\npressure = \"1 N\"", &["is a stress", "a force"]),
        ("[[force]]\nmaterial = \"soft\"\npressure = [[0, 1, 2]]", &["a row [time, number]"]),
        ("[[force]]\nmaterial = \"hard\"\ntotal = [1, 0, 0]", &["is rigid", "material.NAME.force"]),
        ("[[force]]\nmaterial = \"soft\"\ntotal = [1, 0, 0]\nside = \"+x\"", &["side", "a total"]),
        (
            "[[force]]\nmaterial = \"soft\"\npressure = 1\nside = \"+x\"\nregion = { sphere = { center = [0.0075, 0.0075, 0.0075], radius = 0.001 } }",
            &["lies on the surface", "`side`"],
        ),
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

/// Rigid bodies that could not move as they should.
#[test]
fn rigid_bodies() {
    let with = |more: &str| GOOD.replace("motion = \"free\"", &format!("motion = \"free\"\n{more}"));
    let (error, _) = refused(&with("locked = \"x\""), &[]);
    assert!(
        error.contains("\"tool\" starts with a velocity along x") && error.contains("unlock it"),
        "{error}"
    );
    let (error, _) = refused(&with("angular-velocity = [0, 0, 1]\nlocked-turns = \"z\""), &[]);
    assert!(error.contains("starts turning about z"), "{error}");
    // half a ball on a mirror may not leave it
    let half = |more: &str| {
        with(more)
            .replace("center = [\"50 mm\", \"20 mm\", \"20 mm\"]", "center = [\"50 mm\", 0, \"20 mm\"]")
            .replace("x-min = \"fixed\"", "y-min = \"symmetric\"")
    };
    let (error, _) = refused(&half(""), &[]);
    assert!(error.contains("a mirror cuts") && error.contains("`locked-turns`"), "{error}");
    let (error, _) = refused(&half("locked = \"y\"\nlocked-turns = \"x\""), &[]);
    assert!(error.contains("a mirror cuts"), "{error}");
    read_text("test", &half("locked = \"y\"\nlocked-turns = \"xz\""), &[], None)
        .expect("it moves along the mirror");
    // what is held along some axes alone, by itself or by a bond
    let held = "\n[[drive]]\nmaterial = \"soft\"\ncomponents = \"xz\"\n";
    let (error, _) = refused(&format!("{}{held}", GOOD), &[]);
    assert!(error.contains("along some axes alone") && error.contains("components = \"xyz\""), "{error}");
    let criterion =
        GOOD.replace("friction = 0.1", "friction = 0.1\ncriterion = \"approach-and-compression\"");
    let (error, _) = refused(&criterion, &[]);
    assert!(error.contains("no traction") && error.contains("approach"), "{error}");
    let two = with("").replace(
        "[[contact]]",
        "[material.other]\nlaw = \"rigid\"\nmotion = \"free\"\ndensity = 1\n[[body]]\nname = \"wall\"\nmaterial = \"other\"\n\
         shape = { box = { lower = [\"70 mm\", 0, 0], upper = [\"75 mm\", 0.04, 0.04] } }\n\
         [[contact]]\nbetween = [\"hard\", \"other\"]\nlaw = \"friction\"\nfriction = 0\n[[contact]]",
    );
    let (error, _) = refused(&two, &[]);
    assert!(error.contains("are both rigid") && error.contains("ends if they ever meet"), "{error}");
}

/// Bonds that could not part, or that would say what they do not do.
#[test]
fn bonds() {
    let bond =
        |more: &str| GOOD.replace("law = \"friction\"\nfriction = 0.1", &format!("law = \"bonded\"\n{more}"));
    for (more, facts) in [
        ("friction = 0.1", ["never breaks", "contact.0.friction"]),
        ("gap = 0.5", ["holds whatever the gap", "leave out `gap`"]),
        (
            "normal-strength = \"1 kPa\"",
            ["\"hard\" has a strength, which is not modelled", "leave out the strength"],
        ),
    ] {
        let (error, _) = refused(&bond(more), &[]);
        assert!(facts.iter().all(|fact| error.contains(fact)), "{more}: {error}");
    }
    read_text("test", &bond(""), &[], None).expect("a bond");
}
