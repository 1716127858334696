// Matrices of a palette: three rows of a 3x4 matrix. docs/formats/crowd-buffers.md, version 1.

struct ArticulaRows {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

fn articula_mix(a: ArticulaRows, b: ArticulaRows, share: f32) -> ArticulaRows {
    return ArticulaRows(
        a.x + (b.x - a.x) * share,
        a.y + (b.y - a.y) * share,
        a.z + (b.z - a.z) * share,
    );
}

// Adds a matrix times a weight.
fn articula_add(sum: ArticulaRows, more: ArticulaRows, weight: f32) -> ArticulaRows {
    return ArticulaRows(
        sum.x + more.x * weight,
        sum.y + more.y * weight,
        sum.z + more.z * weight,
    );
}

fn articula_point(m: ArticulaRows, point: vec3<f32>) -> vec3<f32> {
    let p = vec4<f32>(point, 1.0);
    return vec3<f32>(dot(m.x, p), dot(m.y, p), dot(m.z, p));
}

// The normal of a surface that the matrix has moved, by its cofactor matrix; of unit length. Normals
// point outwards of a matrix that mirrors too.
fn articula_normal(m: ArticulaRows, normal: vec3<f32>) -> vec3<f32> {
    let first = cross(m.y.xyz, m.z.xyz);
    let side = select(1.0, -1.0, dot(m.x.xyz, first) < 0.0);
    let moved = side * vec3<f32>(
        dot(first, normal),
        dot(cross(m.z.xyz, m.x.xyz), normal),
        dot(cross(m.x.xyz, m.y.xyz), normal),
    );
    return moved * inverseSqrt(max(dot(moved, moved), 1e-30));
}

// The matrix of a rotation and a translation.
fn articula_rigid(rotation: vec4<f32>, translation: vec3<f32>) -> ArticulaRows {
    let q = rotation;
    let two = q + q;
    let xx = two.x * q.x;
    let yy = two.y * q.y;
    let zz = two.z * q.z;
    let xy = two.x * q.y;
    let xz = two.x * q.z;
    let yz = two.y * q.z;
    let wx = two.x * q.w;
    let wy = two.y * q.w;
    let wz = two.z * q.w;
    return ArticulaRows(
        vec4<f32>(1.0 - yy - zz, xy - wz, xz + wy, translation.x),
        vec4<f32>(xy + wz, 1.0 - xx - zz, yz - wx, translation.y),
        vec4<f32>(xz - wy, yz + wx, 1.0 - xx - yy, translation.z),
    );
}

// World transforms of all characters, three rows each.
@group(1) @binding(2) var<storage, read> articula_transforms: array<vec4<f32>>;

// World-from-model transform of a character.
fn articula_world(character: u32) -> ArticulaRows {
    let at = character * 3u;
    return ArticulaRows(
        articula_transforms[at],
        articula_transforms[at + 1u],
        articula_transforms[at + 2u],
    );
}
