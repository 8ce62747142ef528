//! Textures on the device: four values for each texel, in layers of tiles where they are larger than what
//! the device allows.

use uvgraft::{Depth, Size, TexelFormat, Texels, Texture, Value};
use wgpu::{Extent3d, Origin3d, TexelCopyBufferLayout, TextureFormat, TextureUsages};

use crate::{Gpu, GpuError};

/// Maximum number of bytes that are converted and moved at once.
const BAND: usize = 16 << 20;

/// A texture on the device.
#[derive(Debug, Clone)]
pub struct DeviceTexture {
    pub(crate) texture: wgpu::Texture,
    size: Size,
    format: TexelFormat,
    pub(crate) tiles: Tiles,
}

/// How a texture is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tiles {
    /// Logarithm of a tile's side.
    pub bits: u32,
    /// Tiles in a row.
    pub columns: u32,
    rows: u32,
}

impl Tiles {
    fn new(size: Size, bits: u32) -> Self {
        let side = 1 << bits;
        Self { bits, columns: size.width.div_ceil(side), rows: size.height.div_ceil(side) }
    }

    /// The side of tiles, which a texture of one tile need not fill.
    fn extent(self, size: Size) -> Extent3d {
        let side = 1 << self.bits;
        Extent3d {
            width: size.width.min(side),
            height: size.height.min(side),
            depth_or_array_layers: self.columns * self.rows,
        }
    }
}

impl DeviceTexture {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The format that it is downloaded in.
    pub fn format(&self) -> TexelFormat {
        self.format
    }

    /// The texture with four 8-bit, 16-bit or float values for each texel: red, green, blue and alpha, or grey in
    /// the place of red. One layer, unless it is larger than what the device allows.
    pub fn as_wgpu(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Whether the last channel is alpha; the fourth channel of data is data.
    pub(crate) fn has_alpha(&self) -> bool {
        self.format.channels.has_alpha() && self.format.encoding != uvgraft::Encoding::Data
    }

    pub(crate) fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }

    /// Copies all texels from a texture of the same size and format.
    pub(crate) fn copy_from(&self, other: &Self, encoder: &mut wgpu::CommandEncoder) {
        let [from, to] = [&other.texture, &self.texture].map(wgpu::Texture::as_image_copy);
        encoder.copy_texture_to_texture(from, to, self.texture.size());
    }
}

/// The device's format for a depth.
pub(crate) const fn device_format(depth: Depth) -> TextureFormat {
    match depth {
        Depth::U8 => TextureFormat::Rgba8Uint,
        Depth::U16 => TextureFormat::Rgba16Uint,
        Depth::F32 => TextureFormat::Rgba32Float,
    }
}

impl Gpu {
    /// Copies a texture to the device.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::Memory`] or [`GpuError::Device`].
    pub fn upload(&self, texture: &Texture) -> Result<DeviceTexture, GpuError> {
        let on_device = self.texture(texture.size(), texture.format())?;
        match texture.texels() {
            Texels::U8(values) => self.write(&on_device, values),
            Texels::U16(values) => self.write(&on_device, values),
            Texels::F32(values) => self.write(&on_device, values),
        }
        self.check()?;
        Ok(on_device)
    }

    /// Copies a texture from the device, and waits for it.
    ///
    /// # Errors
    /// [`GpuError::Memory`] or [`GpuError::Device`].
    #[cfg(not(target_family = "wasm"))]
    pub fn download(&self, texture: &DeviceTexture) -> Result<Texture, GpuError> {
        pollster::block_on(self.read(texture))
    }

    /// As [`Gpu::download`], for browsers, where nothing may block.
    ///
    /// # Errors
    /// As [`Gpu::download`].
    pub async fn read(&self, texture: &DeviceTexture) -> Result<Texture, GpuError> {
        let texels = match texture.format.depth {
            Depth::U8 => Texels::U8(self.values(texture).await?),
            Depth::U16 => Texels::U16(self.values(texture).await?),
            Depth::F32 => Texels::F32(self.values(texture).await?),
        };
        let TexelFormat { channels, encoding, .. } = texture.format;
        Ok(Texture::new(texture.size, channels, encoding, texels)
            .expect("as many values as texels have"))
    }

    /// A texture with unspecified values.
    pub(crate) fn texture(
        &self,
        size: Size,
        format: TexelFormat,
    ) -> Result<DeviceTexture, GpuError> {
        let tiles = Tiles::new(size, self.limits.tile_bits);
        let extent = tiles.extent(size);
        if extent.depth_or_array_layers > self.limits.tiles {
            return Err(GpuError::TooLarge { what: "a texture", size });
        }
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: device_format(format.depth),
            usage: TextureUsages::TEXTURE_BINDING
                | TextureUsages::STORAGE_BINDING
                | TextureUsages::COPY_SRC
                | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        self.check()?;
        Ok(DeviceTexture { texture, size, format, tiles })
    }

    /// Writes all texels of a texture.
    fn write<T: Value + bytemuck::Pod>(&self, texture: &DeviceTexture, values: &[T]) {
        let (count, width) = (texture.format.channels.count(), texture.size.width as usize);
        for part in parts(texture, size_of::<T>()) {
            let row = part.extent.width as usize;
            let mut expanded = vec![T::ONE; row * part.extent.height as usize * 4];
            for (y, texels) in (part.y as usize..).zip(expanded.chunks_exact_mut(row * 4)) {
                let from = &values[(y * width + part.x as usize) * count..][..row * count];
                for (texel, from) in
                    texels.as_chunks_mut::<4>().0.iter_mut().zip(from.chunks_exact(count))
                {
                    *texel = expand(from);
                }
            }
            let layout = TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((row * 4 * size_of::<T>()) as u32),
                rows_per_image: None,
            };
            let bytes = bytemuck::cast_slice(&expanded);
            self.queue.write_texture(part.of(&texture.texture), bytes, layout, part.extent);
        }
    }

    /// Reads all texels of a texture.
    async fn values<T: Value + bytemuck::Pod>(
        &self,
        texture: &DeviceTexture,
    ) -> Result<Vec<T>, GpuError> {
        let (count, width) = (texture.format.channels.count(), texture.size.width as usize);
        let mut values = vec![T::default(); texture.size.texels() * count];
        for part in parts(texture, size_of::<T>()) {
            let row = part.extent.width as usize * 4 * size_of::<T>();
            // Rows in buffers begin at multiples of this.
            let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: (stride * part.extent.height as usize) as u64,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder =
                self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let layout = TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(stride as u32),
                rows_per_image: None,
            };
            encoder.copy_texture_to_buffer(
                part.of(&texture.texture),
                wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
                part.extent,
            );
            self.queue.submit([encoder.finish()]);
            self.check()?;
            let (sender, mapped) = futures_channel::oneshot::channel();
            buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                // Nobody waits for it once this future has been dropped.
                let _ = sender.send(result);
            });
            // Browsers do this by themselves.
            #[cfg(not(target_family = "wasm"))]
            self.wait()?;
            let failed = |error: &dyn std::fmt::Display| GpuError::Device(error.to_string());
            mapped.await.map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
            let bytes = buffer.get_mapped_range(..).map_err(|error| failed(&error))?;
            for (y, bytes) in (part.y as usize..).zip(bytes.chunks_exact(stride)) {
                let to = (y * width + part.x as usize) * count;
                let to = values[to..].chunks_exact_mut(count);
                let from: &[[T; 4]] = bytemuck::cast_slice(&bytes[..row]);
                for (texel, from) in to.zip(from) {
                    contract(*from, texel);
                }
            }
        }
        Ok(values)
    }
}

/// A texel of the device: grey stands in the place of red, and alpha, which may be missing, is last.
fn expand<T: Value>(texel: &[T]) -> [T; 4] {
    match *texel {
        [grey] => [grey, T::default(), T::default(), T::ONE],
        [grey, alpha] => [grey, T::default(), T::default(), alpha],
        [red, green, blue] => [red, green, blue, T::ONE],
        _ => [texel[0], texel[1], texel[2], texel[3]],
    }
}

/// The inverse of [`expand`].
fn contract<T: Value>(from: [T; 4], texel: &mut [T]) {
    if let [grey, alpha] = texel {
        [*grey, *alpha] = [from[0], from[3]];
    } else {
        texel.copy_from_slice(&from[..texel.len()]);
    }
}

/// A part of a texture within a layer.
struct Part {
    /// Column and row of its first texel in the texture.
    x: u32,
    y: u32,
    /// The same in its layer.
    origin: Origin3d,
    extent: Extent3d,
}

impl Part {
    fn of<'t>(&self, texture: &'t wgpu::Texture) -> wgpu::TexelCopyTextureInfo<'t> {
        wgpu::TexelCopyTextureInfo { origin: self.origin, ..texture.as_image_copy() }
    }
}

/// Divides a texture into parts that are moved at once.
fn parts(texture: &DeviceTexture, value: usize) -> Vec<Part> {
    let (Size { width, height }, tiles) = (texture.size, texture.tiles);
    let side = 1_u32 << tiles.bits;
    let mut parts = Vec::new();
    for z in 0..tiles.columns * tiles.rows {
        let x = z % tiles.columns * side;
        let top = z / tiles.columns * side;
        let (columns, bottom) = ((width - x).min(side), (top + side).min(height));
        let at_once = (BAND / (columns as usize * 4 * value)).max(1);
        for y in (top..bottom).step_by(at_once) {
            let height = (bottom - y).min(at_once as u32);
            parts.push(Part {
                x,
                y,
                origin: Origin3d { x: 0, y: y - top, z },
                extent: Extent3d { width: columns, height, depth_or_array_layers: 1 },
            });
        }
    }
    parts
}
