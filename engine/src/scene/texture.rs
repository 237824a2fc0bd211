//! Textures of triangles: base colour, highlights, emission, opacity, cut-outs, normals and occlusion.

use super::{
    Checker, Image, MaterialId, NormalMap, OcclusionMap, Opacity, Primitive, Scene, Texture,
    material::check_range,
};
use crate::{
    error::SceneError,
    ray::{InstanceId, PrimitiveId, SceneHit},
};
use glam::{DVec3, Vec3};

/// The strongest emission, so that sums of samples stay finite.
pub const MAX_EMISSION: f32 = 1e6;

/// The textures of a material, and the light that it emits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceTextures {
    /// Multiplies the base colour.
    pub base: Option<Texture>,
    /// Multiplies the base colour, too.
    pub checker: Option<Checker>,
    /// Cut-outs: where rays pass.
    pub cut_out: Option<CutOut>,
    /// Opacity outside of cut-outs; `None` for glass.
    pub opacity: Option<Opacity>,
    /// Emitted light, linear RGB from 0 to [`MAX_EMISSION`]. It does not light other surfaces. Pictures of bytes show up to
    /// 1, but mirrors, glass and half-transparent surfaces dim it first.
    pub emission: [f32; 3],
    /// Multiplies the colour of Blinn-Phong's highlight.
    pub specular_map: Option<Texture>,
    /// Multiplies the emission.
    pub emission_map: Option<Texture>,
    /// Changes the shading normals.
    pub normal_map: Option<NormalMap>,
    /// Multiplies ambient light and that of the environment.
    pub occlusion_map: Option<OcclusionMap>,
    /// Whether triangles are invisible from behind, where their corners are clockwise, to camera rays and those that mirrors,
    /// glass and half-transparent surfaces pass on. Shadow rays and ambient occlusion rays stop at both sides.
    pub one_sided: bool,
}

/// Cuts out the parts of a surface where a channel of an image is below a limit: no ray hits them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOut {
    /// The image; mipmaps are not used.
    pub texture: Texture,
    /// Which of its channels, 0 for red to 3 for alpha.
    pub channel: u8,
    /// Threshold, 0 or more; above 1 all of the surface is cut out.
    pub limit: f32,
}

/// A hit, and the ray's footprint there.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// The hit, with the barycentric weights.
    pub hit: SceneHit,
    /// The point relative to [`Scene::origin`], scene units; only for [`SurfaceTextures::checker`].
    pub point: Vec3,
    /// Unit geometric normal on any side; only for [`SurfaceTextures::checker`].
    pub normal: Vec3,
    /// Unit direction of the ray.
    pub direction: Vec3,
    /// Width of the ray's cone at the hit, scene units; 0 for the largest level.
    ///
    /// A camera ray's cone is as wide as its pixel (Akenine-Möller et al., *Texture Level of Detail Strategies for
    /// Real-Time Ray Tracing*, Ray Tracing Gems ch. 20, 2019). Mirrors do not change its angle.
    pub width: f32,
}

/// What textures and emission give to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedPoint {
    /// Factors of the base colour, linear RGB.
    pub base: [f32; 3],
    /// Factors of the highlight's colour.
    pub specular: [f32; 3],
    /// The light emitted there, linear RGB.
    pub emitted: [f32; 3],
}

impl TexturedPoint {
    /// That of a surface without textures and emission.
    const PLAIN: Self = Self {
        base: [1.0; 3],
        specular: [1.0; 3],
        emitted: [0.0; 3],
    };
}

/// Lower bound on the cosine between ray and normal: smaller ones would blur surfaces at grazing angles to one colour.
const LEAST_COSINE: f64 = 1.0 / 16.0;

impl SurfaceTextures {
    /// No textures and no emission.
    pub const NONE: Self = Self {
        base: None,
        checker: None,
        cut_out: None,
        opacity: None,
        emission: [0.0; 3],
        specular_map: None,
        emission_map: None,
        normal_map: None,
        occlusion_map: None,
        one_sided: false,
    };

    /// The same textures with other images: image `i` becomes `images[i]`, or an invalid index if `images` is too short.
    #[doc(hidden)]
    #[must_use]
    pub fn with_images(&self, images: &[u32]) -> Self {
        let mut other = *self;
        for texture in other.all_mut().into_iter().flatten() {
            texture.image = images.get(texture.image as usize).copied().unwrap_or(u32::MAX);
        }
        other
    }

    /// Rejects constants out of range and missing images.
    pub(super) fn check(&self, images: usize) -> Result<(), SceneError> {
        for channel in self.emission {
            check_range("emission", channel, (0.0, MAX_EMISSION))?;
        }
        if let Some(checker) = self.checker {
            checker.check()?;
        }
        if let Some(opacity) = self.opacity {
            opacity.check()?;
        }
        if let Some(map) = self.normal_map {
            map.check()?;
        }
        if let Some(map) = self.occlusion_map {
            map.check()?;
        }
        for texture in self.all().into_iter().flatten() {
            if texture.image as usize >= images {
                let index = texture.image;
                return Err(SceneError::UnknownImage { index, images });
            }
        }
        match self.cut_out {
            Some(CutOut { channel, .. }) if channel > 3 => Err(SceneError::OutOfRange {
                what: "channel",
                value: f32::from(channel),
                range: (0.0, 3.0),
            }),
            Some(CutOut { limit, .. }) if !(limit >= 0.0 && limit.is_finite()) => {
                Err(SceneError::OutOfRange {
                    what: "cut-out limit",
                    value: limit,
                    range: (0.0, f32::MAX),
                })
            }
            _ => Ok(()),
        }
    }

    /// Returns all textures.
    #[doc(hidden)]
    pub fn all(&self) -> [Option<Texture>; 7] {
        [
            self.base,
            self.cut_out.map(|cut_out| cut_out.texture),
            self.opacity.and_then(|opacity| opacity.map),
            self.specular_map,
            self.emission_map,
            self.normal_map.map(|map| map.texture),
            self.occlusion_map.map(|map| map.texture),
        ]
    }

    /// The place of the specular map in [`SurfaceTextures::all`].
    #[doc(hidden)]
    pub const SPECULAR: usize = 3;

    /// The place of the normal map in [`SurfaceTextures::all`].
    #[doc(hidden)]
    pub const NORMAL: usize = 5;

    /// The place of the occlusion map in [`SurfaceTextures::all`].
    #[doc(hidden)]
    pub const OCCLUSION: usize = 6;

    /// Returns all textures, in the same order.
    #[doc(hidden)]
    pub fn all_mut(&mut self) -> [Option<&mut Texture>; 7] {
        [
            self.base.as_mut(),
            self.cut_out.as_mut().map(|cut_out| &mut cut_out.texture),
            self.opacity.as_mut().and_then(|opacity| opacity.map.as_mut()),
            self.specular_map.as_mut(),
            self.emission_map.as_mut(),
            self.normal_map.as_mut().map(|map| &mut map.texture),
            self.occlusion_map.as_mut().map(|map| &mut map.texture),
        ]
    }

    /// Returns whether the surface emits light.
    #[inline]
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission != [0.0; 3]
    }
}

impl Scene {
    /// Returns the images that [`Texture`]s index.
    #[must_use]
    pub fn images(&self) -> &[Image] {
        &self.images
    }

    /// Returns the textures of a primitive's material; `None` if it has none.
    #[inline]
    #[must_use]
    pub fn textures_of(&self, id: PrimitiveId) -> Option<&SurfaceTextures> {
        if self.textures.is_empty() {
            return None;
        }
        self.textures(self.material_of(id))
    }

    /// Returns the textures of a material; `None` if it has none.
    #[inline]
    #[must_use]
    pub fn textures(&self, material: MaterialId) -> Option<&SurfaceTextures> {
        self.textures.get(material.0 as usize)?.as_ref()
    }

    /// Returns whether any material has textures, emits light or is not opaque.
    #[inline]
    #[must_use]
    pub fn has_textures(&self) -> bool {
        !self.textures.is_empty()
    }

    /// Returns whether an image cuts out this point of a triangle.
    pub(super) fn cuts_out(&self, textures: &SurfaceTextures, i: usize, weights: [f32; 2]) -> bool {
        textures.cut_out.is_some_and(|cut_out| {
            let color = self.images[cut_out.texture.image as usize].color(
                cut_out.texture,
                self.texture_coordinates(i, weights),
                0.0,
            );
            color[usize::from(cut_out.channel)] < cut_out.limit
        })
    }

    /// Returns what textures and emission give to a hit.
    #[must_use]
    pub fn textured(&self, point: &TexturePoint) -> TexturedPoint {
        let Some(textures) = self.textures_of(point.hit.primitive) else {
            return TexturedPoint::PLAIN;
        };
        let checker = textures.checker.map_or([1.0; 3], |checker| {
            let at = point.point.as_dvec3() + self.origin.as_dvec3() + self.offset;
            checker.color(at, point.normal, point.direction, point.width)
        });
        let plain = TexturedPoint {
            base: checker,
            emitted: textures.emission,
            ..TexturedPoint::PLAIN
        };
        let Primitive::Triangle(i) = self.primitive(point.hit.primitive) else {
            return plain;
        };
        let maps = [textures.base, textures.specular_map, textures.emission_map];
        if maps == [None; 3] {
            return plain;
        }
        let lookup = Lookup::new(self, i, point);
        let [base, specular, emitted] =
            maps.map(|map| map.map_or([1.0; 3], |texture| lookup.color(self, texture)));
        TexturedPoint {
            base: std::array::from_fn(|channel| base[channel] * checker[channel]),
            specular,
            emitted: std::array::from_fn(|channel| textures.emission[channel] * emitted[channel]),
        }
    }

    /// Returns the share of the image's area that the ray's cone covers: an ellipse that lengthens at grazing angles.
    fn footprint(&self, i: usize, point: &TexturePoint) -> f64 {
        let [p0, p1, p2] = self.placed_corners(i, point.hit.instance);
        let [a, b, c] = self.corner_coordinates(i);
        let normal = (p1 - p0).cross(p2 - p0);
        let image = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let length = dot(normal, normal).sqrt();
        let cosine = dot(normal, point.direction.as_dvec3()).abs() / length;
        let width = f64::from(point.width);
        image.abs() / length * width * width / cosine.max(LEAST_COSINE)
    }

    /// The corners of a triangle in the world.
    pub(super) fn placed_corners(&self, i: usize, instance: InstanceId) -> [DVec3; 3] {
        let mut corners = self.triangle(i);
        if let Some(instance) = self.instance(instance) {
            let placement = instance.placement();
            corners = corners.map(|corner| placement.point(corner));
        }
        corners.map(Vec3::as_dvec3)
    }

    /// The texture coordinates of a triangle's corners.
    pub(super) fn corner_coordinates(&self, i: usize) -> [[f64; 2]; 3] {
        self.triangles.corners[i].map(|vertex| self.uv(vertex).map(f64::from))
    }

    /// Returns the texture coordinates at weights of the second and third corner.
    pub(super) fn texture_coordinates(&self, i: usize, [u, v]: [f32; 2]) -> [f32; 2] {
        let [a, b, c] = self.triangles.corners[i].map(|vertex| self.uv(vertex));
        let w = 1.0 - u - v;
        std::array::from_fn(|axis| a[axis] * w + b[axis] * u + c[axis] * v)
    }

    fn uv(&self, vertex: u32) -> [f32; 2] {
        self.vertices
            .uvs
            .get(vertex as usize)
            .copied()
            .unwrap_or_default()
    }
}

/// Where a ray meets the images of a triangle.
pub(super) struct Lookup {
    /// Texture coordinates.
    at: [f32; 2],
    /// The share of an image's area that the ray's cone covers.
    footprint: f64,
}

impl Lookup {
    pub(super) fn new(scene: &Scene, i: usize, point: &TexturePoint) -> Self {
        Self {
            at: scene.texture_coordinates(i, [point.hit.u, point.hit.v]),
            footprint: scene.footprint(i, point),
        }
    }

    /// The red, green and blue of an image.
    pub(super) fn color(&self, scene: &Scene, texture: Texture) -> [f32; 3] {
        let image = &scene.images[texture.image as usize];
        let [width, height] = image.size().map(f64::from);
        // Half of the logarithm, because it is that of an area.
        let lod = 0.5 * libm::log2f((self.footprint * width * height) as f32);
        let [red, green, blue, _] = image.color(texture, self.at, lod);
        [red, green, blue]
    }
}

/// Sums in one order, whatever the library does.
pub(super) fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
