//! The shaders of crowds are valid WGSL and declare what their page says.

use articula::crowd::{PaletteForm, wgsl};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};

const FORMS: [PaletteForm; 4] = [
    PaletteForm::Matrix,
    PaletteForm::HalfMatrix,
    PaletteForm::Rigid,
    PaletteForm::HalfRigid,
];

/// Parses and validates a shader. To unpack halves needs a capability of its own, which WebGPU has and
/// WebGL lacks.
fn valid(source: &str) -> Module {
    let needed = match source.contains("unpack2x16float") {
        true => Capabilities::SHADER_FLOAT16_IN_FLOAT32,
        false => Capabilities::empty(),
    };
    let module = naga::front::wgsl::parse_str(source);
    let module = module.unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    let mut judge = Validator::new(ValidationFlags::all(), needed);
    if let Err(e) = judge.validate(&module) {
        panic!("{}", e.emit_to_string(source));
    }
    module
}

fn all() -> Vec<(&'static str, Option<PaletteForm>)> {
    let draws = FORMS.map(|form| (wgsl::draws(form), Some(form)));
    let records = FORMS
        .iter()
        .filter_map(|form| Some((wgsl::records(*form)?, None)));
    draws.into_iter().chain(records).collect()
}

#[test]
fn all_are_valid_and_bind_three_buffers_to_read() {
    for (source, form) in all() {
        let module = valid(source);
        assert_eq!(
            module.entry_points.len(),
            0,
            "the renderer has the entry points"
        );
        let mut bound = Vec::new();
        for (_, variable) in module.global_variables.iter() {
            let binding = variable.binding.as_ref().unwrap();
            assert_eq!(binding.group, 1);
            let access = StorageAccess::LOAD;
            assert_eq!(variable.space, AddressSpace::Storage { access });
            let TypeInner::Array { stride, .. } = module.types[variable.ty].inner else {
                panic!("{:?} is no array", variable.name);
            };
            bound.push((binding.binding, variable.name.clone().unwrap(), stride));
        }
        bound.sort();
        let strides = bound.iter().map(|b| b.2).collect::<Vec<_>>();
        let named: Vec<&str> = bound.iter().map(|b| b.1.as_str()).collect();
        let row = |form: PaletteForm| (form.bytes() / form.rows()) as u32;
        match form {
            Some(form) => {
                assert_eq!(
                    named,
                    ["articula_palettes", "articula_draws", "articula_transforms"]
                );
                assert_eq!(strides, [row(form), 8, 16]);
            }
            None => {
                assert_eq!(
                    named,
                    [
                        "articula_palettes",
                        "articula_records",
                        "articula_transforms"
                    ]
                );
                assert_eq!(strides[1..], [16, 16]);
            }
        }
        let named = |name: &str| {
            let mut functions = module.functions.iter();
            functions.any(|(_, f)| f.name.as_deref() == Some(name))
        };
        for name in ["skin", "add", "point", "normal", "world", "character"] {
            assert!(named(&format!("articula_{name}")), "{name}");
        }
    }
    assert_eq!(all().len(), 6);
}

#[test]
fn a_vertex_shader_fits_behind_each() {
    const VERTEX: &str = "
        @group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;

        struct Out {
            @builtin(position) position: vec4<f32>,
            @location(0) normal: vec3<f32>,
        }

        @vertex
        fn vertex(
            @builtin(instance_index) instance: u32,
            @location(0) position: vec3<f32>,
            @location(1) normal: vec3<f32>,
            @location(3) entries: vec4<u32>,
            @location(4) weights: vec4<f32>,
        ) -> Out {
            let skin = articula_skin(instance, entries, weights);
            let world = articula_world(articula_character(instance));
            let place = articula_point(world, articula_point(skin, position));
            let turned = articula_normal(world, articula_normal(skin, normal));
            return Out(clip_from_world * vec4<f32>(place, 1.0), turned);
        }";
    for (source, _) in all() {
        let module = valid(&format!("{source}{VERTEX}"));
        assert_eq!(module.entry_points.len(), 1);
    }
}

#[test]
fn impostors_are_valid_and_bind_what_their_page_says() {
    let vertex = r"
        @vertex
        fn vertex(
            @builtin(instance_index) instance: u32,
            @builtin(vertex_index) corner: u32,
        ) -> @builtin(position) vec4<f32> {
            let shown = articula_impostor(instance, corner, vec3<f32>(0.0, 1.7, 9.0));
            return vec4<f32>(shown.place + vec3<f32>(shown.texel, 0.0), 1.0);
        }";
    valid(wgsl::IMPOSTORS);
    let module = valid(&format!("{}{vertex}", wgsl::IMPOSTORS));
    let mut bound: Vec<(u32, String)> = module
        .global_variables
        .iter()
        .filter_map(|(_, v)| Some((v.binding.as_ref()?.binding, v.name.clone()?)))
        .collect();
    bound.sort();
    let expected = [
        (1, "articula_impostors"),
        (2, "articula_transforms"),
        (3, "articula_cells"),
        (4, "articula_centres"),
        (5, "articula_view_rows"),
    ];
    let expected = expected.map(|(at, name)| (at, name.to_owned()));
    assert_eq!(bound, expected);
    let cells = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some("ArticulaImpostorCells"));
    let Some((
        _,
        naga::Type {
            inner: TypeInner::Struct { span, .. },
            ..
        },
    )) = cells
    else {
        panic!("the cells are a struct");
    };
    assert_eq!(*span, 32, "bytes of ImpostorBuffers::cells");
}
