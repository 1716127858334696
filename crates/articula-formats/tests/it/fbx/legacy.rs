//! Version 6.1, whose connections name objects instead of numbering them.

use super::read;

const FILE: &str = r#"; FBX 6.1.0 project file
FBXHeaderExtension:  {
    FBXHeaderVersion: 1003
    FBXVersion: 6100
}
Objects:  {
    Model: "Model::Hips", "LimbNode" {
        Version: 232
        Properties60:  {
            Property: "Lcl Translation", "Lcl Translation", "A+",0,98,0
        }
    }
    Model: "Model::Spine", "LimbNode" {
        Version: 232
        Properties60:  {
            Property: "Lcl Translation", "Lcl Translation", "A+",0,20,0
        }
    }
}
Connections:  {
    Connect: "OO", "Model::Hips", "Model::Scene"
    Connect: "OO", "Model::Spine", "Model::Hips"
}
Takes:  {
    Current: "Take 001"
    Take: "Take 001" {
        LocalTime: 0,46186158000
        ReferenceTime: 0,46186158000
        Model: "Model::Spine" {
            Version: 1.1
            Channel: "Transform" {
                Channel: "T" {
                    Channel: "X" {
                        Default: 0
                        KeyVer: 4005
                        KeyCount: 2
                        Key: 0,0,L,46186158000,100,L
                    }
                    Channel: "Y" {
                        Default: 20
                    }
                    Channel: "Z" {
                        Default: 0
                    }
                }
            }
        }
    }
}
"#;

#[test]
fn names_connect_objects() {
    let parsed = read(FILE.as_bytes()).unwrap();
    assert!(parsed.warnings.is_empty(), "{:?}", parsed.warnings);
    let character = &parsed.value.character;
    let joints = &character.skeleton.joints;
    assert_eq!(
        (joints[1].name.as_str(), joints[1].parent),
        ("Spine", Some(0))
    );
    assert!((joints[0].rest.translation.y - 0.98).abs() < 1e-6);
    let clip = &character.clips[0];
    assert_eq!((clip.name.as_str(), clip.duration_secs), ("Take 001", 1.0));
    let channel = &clip.channels[0];
    // 24 frames per second, where a file states no rate.
    assert_eq!((channel.target, channel.times_secs.len()), (1, 25));
    assert!((channel.values[channel.values.len() - 3] - 1.0).abs() < 1e-6);
}

#[test]
fn connections_of_names_are_repaired() {
    let wanted = read(FILE.as_bytes()).unwrap().value;
    for (told, added) in [
        (
            "leads to no object",
            r#"Connect: "OO", "Model::Gone", "Model::Hips""#,
        ),
        (
            "two parents",
            r#"Connect: "OO", "Model::Spine", "Model::Scene""#,
        ),
        (
            "between properties",
            r#"Connect: "PP", "Model::Hips", "Model::Spine", "Size""#,
        ),
    ] {
        let file = FILE.replace("}\nTakes:", &format!("    {added}\n}}\nTakes:"));
        let parsed = read(file.as_bytes()).unwrap();
        assert_eq!(parsed.value, wanted);
        let said: Vec<&str> = parsed.warnings.iter().map(|w| w.what.as_str()).collect();
        assert!(matches!(&said[..], [one] if one.contains(told)), "{said:?}");
    }
    let file = FILE.replacen(
        "Properties60:  {",
        "Properties60:  {\nProperty: \"Pfäd\", \"KString\", \"\", \"é\"",
        1,
    );
    let parsed = read(file.as_bytes()).unwrap();
    assert_eq!(parsed.value, wanted);
    assert_eq!(parsed.warnings.len(), 1);
}
