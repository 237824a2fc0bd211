//! Tests of `pose`.

use super::*;

#[test]
fn options_are_exact() {
    let eye = DVec3::new(0.1, 1.0 / 3.0, -2e-9);
    let pose = |projection, lens| Pose {
        eye,
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection,
        lens,
    };
    let height = 10.0 / 3.0;
    let lens = |aperture, focus| Lens { aperture, focus };
    for (projection, lens, expected) in [
        (Projection::DEFAULT, Lens::PINHOLE, "--fov=45".to_owned()),
        // A focus without a lens would be an error.
        (Projection::DEFAULT, lens(0.0, Some(2.0)), "--fov=45".into()),
        (
            Projection::Orthographic { height },
            lens(0.1, None),
            "--ortho=3.3333333333333335 --aperture=0.1".into(),
        ),
        (
            Projection::DEFAULT,
            lens(0.1, Some(height)),
            format!("--fov=45 --aperture=0.1 --focus={height}"),
        ),
    ] {
        let options = pose(projection, lens).options();
        let expected =
            format!("--eye=0.1,0.3333333333333333,-0.000000002 --target=0,0,0 --up=0,0,1 {expected}");
        assert_eq!(options, expected);
    }
}
