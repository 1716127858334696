//! Small files, written by hand.

/// Returns a mask of `width` parameters with those of the given numbers (from 1) set.
pub(crate) fn mask(width: usize, set: &[usize]) -> String {
    let word = |n| if set.contains(&n) { "1" } else { "0" };
    (1..=width).map(word).collect::<Vec<_>>().join(" ")
}

/// Two frames: a viseme and an expression, the jaw opens and stays, the head nods.
pub(crate) fn fap() -> String {
    format!(
        "# a comment\n2.1 talk 25 2\n\n{}\n0 10 0 40 1 1 63 0 0 0 1 120 -4000\n \t{} \n3 -2500\n",
        mask(68, &[1, 2, 3, 48]),
        mask(68, &[48])
    )
}

/// Two frames: the left arm rises forward and stays, the root moves.
pub(crate) fn bap() -> String {
    format!(
        "3.1 arm 25 2\n{}\n0 0 0\n{}\n5 157080 100\n",
        mask(186, &[32, 181]),
        mask(186, &[32, 181])
    )
}

/// One frame with both types of mask.
pub(crate) const EPF: &str = "FBM 1\nFFR 0\nISI 1\nFRR 25 0 0\nTC 0 0 0\nSKN 0\n\
    FMT 3 0 1 1 1 1 0 0 0 0 0 0 0 0 1 2 0 0 0 0 0 0 0 1 0 0 0 0 0 0\nFQU 2\nFIX 60 60\nFBM 2 BQU 3\n";

/// A face with one feature point.
pub(crate) const FDP: &str = r#"<?xml version="1.0"?>
<xfdp>
  <!-- a face -->
  <head>
    <file version="0.2"/>
    <fapu ENS0="51" ES0="69.5" IRISD0="16" MNS0="30" MW0="50"/>
    <translation x="0" y="-1" z="-659"/>
    <rotation axis_angle="1.5707964" axis_x="0" axis_y="2" axis_z="0"/>
  </head>
  <source>
    <entity alias="Rest" category="Expression">
      <mesh file="rest.wrl" format="wrl"/>
      <bind item="LeftEye" pivotX="1" submesh="rest.wrl_1"/>
    </entity>
  </source>
  <fdp affects="rest.wrl_3" index="7" name="2.10">
    <indices>7 8
      9</indices>
    <influence fap="17" type="RaisedCosInfluenceSph" weight="-0.25"/>
    <influence fap="2" type="Other &lt;&#65;&gt;" weight="0"/>
  </fdp>
</xfdp>
"#;
