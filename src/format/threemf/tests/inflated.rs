//! Memory and sizes of what an archive inflates to.

use super::*;

#[test]
fn what_inflates_is_counted_before() {
    let model = format!(
        "<model>{}<!--{}--></model>",
        square("", "", TWO),
        " ".repeat(20_000_000)
    );
    let bomb = archive([("3D/3dmodel.model", model.as_bytes())]);
    assert!(bomb.len() < 100_000);
    let budget = Budget::new(30_000_000);
    assert_eq!(
        read(&bomb, &budget).map(|mesh| mesh.columns.triangles.len()),
        Ok(2)
    );
    assert!(budget.taken() < 100_000, "{}", budget.taken());
    assert_eq!(
        read(&bomb, &Budget::new(10_000_000)).map(|_| ()),
        Err("a.3mf/3D/3dmodel.model: loading takes 19.1 MiB of memory or more, above the memory limit of 9.5 MiB".into())
    );
    let larger = model.replace("<!--", &format!("<!--{}", " ".repeat(50_000_000)));
    let error = read(
        &archive([("3D/3dmodel.model", larger.as_bytes())]),
        &Budget::new(1 << 30),
    );
    assert_eq!(
        error.map(|_| ()),
        Err("a.3mf/3D/3dmodel.model: the part inflates from 66.6 KiB to 66.8 MiB, which no model does: expected at most 200 \
             times"
            .into())
    );
    let many: Vec<(String, Vec<u8>)> = (0..2000).map(|i| (format!("{i}"), Vec::new())).collect();
    let many = archive(many.iter().map(|(name, part)| (&name[..], &part[..])));
    let error = read(&many, &Budget::new(100_000)).expect_err("these are too many");
    assert!(error.starts_with("a.3mf: loading takes"), "{error}");
}

#[test]
fn spaces_do_not_allow_more_triangles() {
    // 64 triangles, doubled 17 times.
    let triangles = TWO
        .replace("</triangles>", "")
        .replace("<triangles>", "")
        .repeat(32);
    let doubled = |i: usize| {
        let component = format!("<component objectid=\"{i}\"/>");
        format!(
            "<object id=\"{}\"><components>{component}{component}</components></object>",
            i + 1
        )
    };
    let model = format!(
        "<model><resources><object id=\"1\"><mesh>{SQUARE}<triangles>{triangles}</triangles></mesh></object>{}</resources>\
         <build><item objectid=\"18\"/></build><!--{}--></model>",
        (1..18).map(doubled).collect::<String>(),
        " ".repeat(5_000_000)
    );
    let bomb = archive([("3D/3dmodel.model", model.as_bytes())]);
    let most = (1 << 22) + 8 * bomb.len();
    assert_eq!(
        read(&bomb, &Budget::unlimited()).map(|_| ()),
        Err(format!(
            "a.3mf: 8388608 triangles, counted once for each component that places them, expected at most {most} from {} \
             bytes",
            bomb.len()
        ))
    );
}
