//! What the program says of itself and of a scene, and what it does where adapters, readers or disks are missing.

use std::io::Read;
use std::process::Stdio;

use crate::command_line::{VIEW, yard_on_gpu};
use crate::program::{Folder, Ran, names_all};
use shadowgraph_testing::{add_box, at, shadowed_yard};

#[test]
fn adapters_are_listed_and_chosen() {
    let Some(folder) = yard_on_gpu() else { return };
    let listed = folder.run("--list-adapters").ok().stdout;
    assert_eq!(folder.run("render --list-adapters").ok().stdout, listed);
    assert_eq!(folder.run("render yard.glb -o out.png --list-adapters").ok().stdout, listed);
    assert_eq!(folder.names("."), ["yard.glb"]);
    for line in listed.lines() {
        let arguments = ["render", "yard.glb", "-o", "out.png", "--size", "8x8", "--adapter"];
        let ran = folder.run_with(arguments.into_iter().chain([line]), &[]).ok();
        names_all(&ran.stderr, &[&format!("adapter: {line}")]);
    }
}

#[test]
fn inspect_prints_summary_tree_closedness_and_plan() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[("depthTest", "zfail")]));
    let summary = folder.run(&format!("inspect yard.glb {VIEW} --size 320x200")).ok();
    let ran = folder.run(&format!("inspect yard.glb {VIEW} --size 320x200 --tree --plan")).ok();
    let place = |text: &str| ran.stdout.find(text).unwrap_or_else(|| panic!("no '{text}': {}", ran.stdout));
    assert!(place("lights\n") < place("nodes\n") && place("nodes\n") < place("casters\n"));
    // The summary comes first, and alone when nothing else is asked for.
    assert!(ran.stdout.starts_with(&summary.stdout), "{}", summary.stdout);
    assert!(!summary.stdout.contains("nodes\n") && !summary.stdout.contains("slot 0"), "{}", summary.stdout);
    names_all(
        &ran.stdout,
        &[
            "'crate' mesh 'crate', 12 triangles",
            "'lamp' point light",
            "'shadows' shadow ShadowVolumeHard closure=none counter=auto depthTest=zfail",
            "lights: all, casters: all",
            "'crate' closed: 0 boundary",
            "'floor' open: 4 boundary",
            "ShadowVolumeHard depthTest=zfail by 'shadows' for 1 caster",
            "cast nothing: 'floor'",
            "'crate' closed, 12 triangles",
            "known error: ",
            "320x200",
            "bytes",
            "volumes of lamp",
        ],
    );
    let other = folder.run("inspect yard.glb --technique none --light directional:0,-1,0").ok();
    names_all(&other.stdout, &["'light0' directional light", "lx: casts no shadow"]);
    assert!(!other.stdout.contains("volumes of"), "{}", other.stdout);
    assert_eq!(folder.names("."), ["yard.glb"]);
}

/// Without any adapter pictures cannot be made, which is said with what to do about it; plans can.
#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_only_inspect_works() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    folder.write("empty.json", "");
    let missing = folder.path("no-such-driver.json");
    for drivers in [missing, folder.path("empty.json")] {
        let drivers = drivers.to_str().expect("it is UTF-8");
        let without =
            [("VK_DRIVER_FILES", drivers), ("VK_ICD_FILENAMES", drivers), ("VK_LOADER_DEBUG", "none")];
        let run = |arguments: &str| folder.run_with(arguments.split_whitespace(), &without);
        let before = folder.contents();
        for arguments in [
            "render yard.glb -o out.png --visibility factors --json out.json",
            "render yard.glb -o out.png --adapter llvmpipe",
            "--list-adapters",
        ] {
            names_all(&run(arguments).error(1), &["no graphics adapter", "install a Vulkan driver"]);
        }
        assert!(before == folder.contents(), "nothing is written");
        names_all(&run("inspect yard.glb --plan").ok().stdout, &["volumes of lamp"]);
    }
}

#[test]
fn help_names_every_option() {
    let folder = Folder::new();
    names_all(&folder.run("--help").ok().stdout, &["render", "inspect", "--list-adapters"]);
    names_all(&folder.run("--version").ok().stdout, &[env!("CARGO_PKG_VERSION")]);
    let scene = [
        "<SCENE>",
        "--size",
        "--camera",
        "--eye",
        "--target",
        "--fov-y",
        "--technique",
        "--light",
        "--floor",
        "--outside-files",
        "--memory",
        "--list-adapters",
    ];
    let help = folder.run("inspect --help").ok().stdout;
    names_all(&help, &scene);
    names_all(&help, &["--tree", "--plan"]);
    let help = folder.run("render --help").ok().stdout;
    names_all(&help, &scene);
    names_all(&help, &["--output", "--visibility", "--error", "--frames", "--json", "--adapter"]);
}

/// A reader that has seen enough (`| head`) is no failure, and a full disk is no panic.
#[test]
#[cfg(target_os = "linux")]
fn stdout_may_end_early() {
    let folder = Folder::new();
    let mut scene = shadowed_yard(&[]);
    for index in 0..500 {
        add_box(&mut scene, &format!("crate {index}"), at(f64::from(index), 1.0, -3.0));
    }
    folder.save("yard.glb", &scene);
    let mut child = folder
        .command(["inspect", "yard.glb", "--tree"], &[])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs");
    let mut first = [0_u8; 5];
    child.stdout.take().expect("it is piped").read_exact(&mut first).expect("it prints");
    assert_eq!(&first, b"504 n", "its first line says how many nodes there are");
    let ended = child.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success() && !stderr.contains("panicked"), "{stderr}");

    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let ended = folder.command(["inspect", "yard.glb"], &[]).stdout(full).output().expect("it runs");
    let stderr = String::from_utf8_lossy(&ended.stderr).into_owned();
    let said = Ran { code: ended.status.code(), stdout: String::new(), stderr }.error(1);
    names_all(&said, &["standard output"]);
}

/// Devices and pipes are written to, not replaced.
#[test]
#[cfg(unix)]
fn output_to_a_device_leaves_the_device() {
    use std::os::unix::fs::FileTypeExt;
    let Some(folder) = yard_on_gpu() else { return };
    folder.run("render yard.glb -o /dev/null --size 8x8").ok();
    let kind = std::fs::metadata("/dev/null").expect("it is still there").file_type();
    assert!(kind.is_char_device());
}
