
// Palettes in the form `half-rigid`: a quaternion and a translation in halves.
@group(1) @binding(0) var<storage, read> articula_palettes: array<vec2<u32>>;

fn articula_entry(index: u32) -> ArticulaRows {
    let at = index * 2u;
    let rotation = articula_halves(articula_palettes[at]);
    let translation = articula_halves(articula_palettes[at + 1u]);
    return articula_rigid(normalize(rotation), translation.xyz);
}
