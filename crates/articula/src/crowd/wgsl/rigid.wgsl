
// Palettes in the form `rigid`: a quaternion and a translation in floats.
@group(1) @binding(0) var<storage, read> articula_palettes: array<vec4<f32>>;

fn articula_entry(index: u32) -> ArticulaRows {
    let at = index * 2u;
    return articula_rigid(articula_palettes[at], articula_palettes[at + 1u].xyz);
}
