//! The humanoid map of a VRM file: which node is which human bone.
//!
//! Source: VRM 0.x (`extensions.VRM`), VRM 1.0 (`extensions.VRMC_vrm`) and VRM animation 1.0
//! (`extensions.VRMC_vrm_animation`), member `humanoid.humanBones`.

use serde_json::Value;

/// Reads the humanoid map of a glTF document: node index and human bone name, in the order of
/// the file. `None` if the document has no such extension; entries without a node are left out.
pub fn vrm_humanoid(json: &Value) -> Option<Vec<(usize, String)>> {
    let bones = |extension: &str| {
        json.get("extensions")?
            .get(extension)?
            .get("humanoid")?
            .get("humanBones")
    };
    let node = |bone: &Value| bone.get("node")?.as_u64()?.try_into().ok();
    if let Some(list) = bones("VRM").and_then(Value::as_array) {
        let entry = |b: &Value| Some((node(b)?, b.get("bone")?.as_str()?.to_owned()));
        return Some(list.iter().filter_map(entry).collect());
    }
    let named = bones("VRMC_vrm")
        .or_else(|| bones("VRMC_vrm_animation"))?
        .as_object()?;
    let entry = |(name, bone): (&String, &Value)| Some((node(bone)?, name.clone()));
    Some(named.iter().filter_map(entry).collect())
}

/// Name of the built-in profile that explains the bones of a humanoid map: the two versions
/// differ in what they call the joints of the thumb.
pub(super) fn profile_of(bones: &[(usize, String)]) -> &'static str {
    let old = bones
        .iter()
        .any(|(_, bone)| bone.ends_with("ThumbIntermediate"));
    if old { "vrm-0" } else { "vrm-1" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn three_forms_are_read() {
        let wanted = Some(vec![(3, "hips".to_owned())]);
        let old = json!({"extensions": {"VRM": {"humanoid": {"humanBones": [
            {"bone": "hips", "node": 3}, {"bone": "spine"}, 7]}}}});
        assert_eq!(vrm_humanoid(&old), wanted);
        for name in ["VRMC_vrm", "VRMC_vrm_animation"] {
            let bones = json!({"hips": {"node": 3}, "spine": {"node": -1}});
            let new = json!({"extensions": {name: {"humanoid": {"humanBones": bones}}}});
            assert_eq!(vrm_humanoid(&new), wanted);
        }
        assert_eq!(vrm_humanoid(&json!({"extensions": {}})), None);
        assert_eq!(vrm_humanoid(&json!(1)), None);
    }
}
