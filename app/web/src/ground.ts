// The ground of the 3-D view: relief coloured by height, and the ruts that the wheels have pressed so far.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  DataUtils,
  Group,
  HalfFloatType,
  LinearFilter,
  Mesh,
  MeshStandardMaterial,
  RedFormat,
  type Texture,
} from 'three';
import { rutRamp, soilRamp } from './colours';
import type { Run } from './data';

const mostVertices = 140000;
const mostTexels = 1 << 20;

interface Field {
  x: Float64Array;
  y: Float64Array;
  h: Float64Array;
}

/** What presses the soil at one instant: contact at (x, y), rolling along (ux, uy). */
export interface Print {
  x: number;
  y: number;
  ux: number;
  uy: number;
  radius: number;
  halfWidth: number;
  sinkage: number;
}

export class GroundView {
  readonly group = new Group();
  readonly lowest: number;
  readonly highest: number;
  readonly size: { x0: number; x1: number; y0: number; y1: number };
  private readonly depth: Float32Array;
  private readonly half: Uint16Array;
  private readonly texture: DataTexture;
  private readonly columns: number;
  private readonly rows: number;
  private readonly uniforms: Record<string, { value: number | Texture | Color | Color[] }>;

  static of(run: Run, wheelWidth: number, fullScale: number): GroundView | null {
    const g = run.header.ground_grid;
    if (!g) return null;
    return new GroundView({ x: run.read(g.x), y: run.read(g.y), h: run.read(g.height) }, wheelWidth, fullScale);
  }

  private constructor(
    private readonly field: Field,
    wheelWidth: number,
    fullScale: number,
  ) {
    const { x, y, h } = field;
    this.size = { x0: x[0], x1: x[x.length - 1], y0: y[0], y1: y[y.length - 1] };
    let lowest = Infinity;
    let highest = -Infinity;
    for (const v of h) {
      lowest = Math.min(lowest, v);
      highest = Math.max(highest, v);
    }
    this.lowest = lowest;
    this.highest = highest;
    const lengthX = this.size.x1 - this.size.x0;
    const lengthY = this.size.y1 - this.size.y0;

    // Texels finer than the wheel, as far as the memory goes.
    const texel = Math.max(Math.min(wheelWidth / 10, 0.02), Math.sqrt((lengthX * lengthY) / mostTexels), lengthX / 4096, lengthY / 4096);
    this.columns = Math.max(2, Math.round(lengthX / texel));
    this.rows = Math.max(2, Math.round(lengthY / texel));
    this.depth = new Float32Array(this.columns * this.rows);
    this.half = new Uint16Array(this.columns * this.rows);
    this.texture = new DataTexture(this.half, this.columns, this.rows, RedFormat, HalfFloatType);
    this.texture.magFilter = this.texture.minFilter = LinearFilter;
    this.texture.needsUpdate = true;

    this.uniforms = {
      rutMap: { value: this.texture },
      rutFull: { value: fullScale },
      texelU: { value: 1 / this.columns },
      texelV: { value: 1 / this.rows },
      texelX: { value: lengthX / this.columns },
      texelY: { value: lengthY / this.rows },
      lowest: { value: lowest },
      relief: { value: Math.max(1e-6, highest - lowest) },
      soil: { value: soilRamp.map((c) => new Color(c)) },
      rut: { value: rutRamp.map((c) => new Color(c)) },
    };
    const cell = Math.max(Math.min(wheelWidth / 3, 0.04), Math.sqrt((lengthX * lengthY) / mostVertices));
    const nx = Math.max(2, Math.ceil(lengthX / cell) + 1);
    const ny = Math.max(2, Math.ceil(lengthY / cell) + 1);
    this.group.add(this.surface(nx, ny), this.skirt(nx, ny));
  }

  /** Height of the undisturbed ground, bilinear. */
  height(x: number, y: number): number {
    const { x: gx, y: gy, h } = this.field;
    const locate = (g: Float64Array, v: number): [number, number] => {
      const p = ((v - g[0]) / (g[g.length - 1] - g[0])) * (g.length - 1);
      const i = Math.min(g.length - 2, Math.max(0, Math.floor(p)));
      return [i, Math.min(1, Math.max(0, p - i))];
    };
    const [i, u] = locate(gx, x);
    const [j, v] = locate(gy, y);
    const n = gx.length;
    const a = h[j * n + i] * (1 - u) + h[j * n + i + 1] * u;
    const b = h[(j + 1) * n + i] * (1 - u) + h[(j + 1) * n + i + 1] * u;
    return a * (1 - v) + b * v;
  }

  clear(): void {
    this.depth.fill(0);
    this.half.fill(0);
    this.texture.needsUpdate = true;
  }

  /** Press a wheel into the ground: depth under a circle of the wheel's radius, kept where it is the greatest so far. */
  press(p: Print): void {
    if (!(p.sinkage > 0)) return;
    const s = Math.min(p.sinkage, p.radius);
    const reach = Math.sqrt(2 * p.radius * s - s * s);
    const dx = (this.size.x1 - this.size.x0) / this.columns;
    const dy = (this.size.y1 - this.size.y0) / this.rows;
    const ex = Math.abs(p.ux) * reach + Math.abs(p.uy) * p.halfWidth;
    const ey = Math.abs(p.uy) * reach + Math.abs(p.ux) * p.halfWidth;
    const i0 = Math.max(0, Math.floor((p.x - ex - this.size.x0) / dx));
    const i1 = Math.min(this.columns - 1, Math.ceil((p.x + ex - this.size.x0) / dx));
    const j0 = Math.max(0, Math.floor((p.y - ey - this.size.y0) / dy));
    const j1 = Math.min(this.rows - 1, Math.ceil((p.y + ey - this.size.y0) / dy));
    for (let j = j0; j <= j1; ++j)
      for (let i = i0; i <= i1; ++i) {
        const rx = this.size.x0 + (i + 0.5) * dx - p.x;
        const ry = this.size.y0 + (j + 0.5) * dy - p.y;
        const along = rx * p.ux + ry * p.uy;
        if (Math.abs(ry * p.ux - rx * p.uy) > p.halfWidth || Math.abs(along) > reach) continue;
        const d = s - (p.radius - Math.sqrt(p.radius * p.radius - along * along));
        const k = j * this.columns + i;
        if (d > this.depth[k]) {
          this.depth[k] = d;
          this.half[k] = DataUtils.toHalfFloat(d);
        }
      }
    this.texture.needsUpdate = true;
  }

  /** Squares of ground that were measured: raised (or pressed, below zero) as they are now. */
  raise(x: Float64Array, y: Float64Array, side: number, rise: Float64Array): void {
    const dx = (this.size.x1 - this.size.x0) / this.columns;
    const dy = (this.size.y1 - this.size.y0) / this.rows;
    for (let c = 0; c < x.length; ++c) {
      const d = DataUtils.toHalfFloat(-rise[c]);
      const i0 = Math.max(0, Math.round((x[c] - 0.5 * side - this.size.x0) / dx));
      const i1 = Math.min(this.columns, Math.max(i0 + 1, Math.round((x[c] + 0.5 * side - this.size.x0) / dx)));
      const j0 = Math.max(0, Math.round((y[c] - 0.5 * side - this.size.y0) / dy));
      const j1 = Math.min(this.rows, Math.max(j0 + 1, Math.round((y[c] + 0.5 * side - this.size.y0) / dy)));
      for (let j = j0; j < j1; ++j) this.half.fill(d, j * this.columns + i0, j * this.columns + i1);
    }
    this.texture.needsUpdate = true;
  }

  private surface(nx: number, ny: number): Mesh {
    const { x0, x1, y0, y1 } = this.size;
    const position = new Float32Array(nx * ny * 3);
    const uv = new Float32Array(nx * ny * 2);
    const index = new Uint32Array((nx - 1) * (ny - 1) * 6);
    for (let j = 0, k = 0; j < ny; ++j)
      for (let i = 0; i < nx; ++i, ++k) {
        const u = i / (nx - 1);
        const v = j / (ny - 1);
        const x = x0 + u * (x1 - x0);
        const y = y0 + v * (y1 - y0);
        position.set([x, y, this.height(x, y)], 3 * k);
        uv.set([u, v], 2 * k);
      }
    for (let j = 0, k = 0; j + 1 < ny; ++j)
      for (let i = 0; i + 1 < nx; ++i, k += 6) {
        const a = j * nx + i;
        index.set([a, a + 1, a + nx + 1, a, a + nx + 1, a + nx], k);
      }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(position, 3));
    geometry.setAttribute('uv', new BufferAttribute(uv, 2));
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.computeVertexNormals();
    const mesh = new Mesh(geometry, this.material());
    mesh.receiveShadow = true;
    return mesh;
  }

  private material(): MeshStandardMaterial {
    const material = new MeshStandardMaterial({ roughness: 0.95, metalness: 0 });
    material.defines = { USE_UV: '' };
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nuniform sampler2D rutMap;\nvarying vec2 vPatch;\nvarying vec3 vGround;')
        .replace(
          '#include <begin_vertex>',
          '#include <begin_vertex>\nvPatch = uv;\nvGround = position;\ntransformed.z -= texture2D(rutMap, uv).r;',
        );
      shader.fragmentShader = shader.fragmentShader
        .replace(
          '#include <common>',
          `#include <common>
uniform sampler2D rutMap;
uniform float rutFull, texelU, texelV, texelX, texelY, lowest, relief;
uniform vec3 soil[3];
uniform vec3 rut[5];
varying vec2 vPatch;
varying vec3 vGround;
float hashOf(vec2 p) { p = fract(p * vec2(123.34, 345.45)); p += dot(p, p + 34.345); return fract(p.x * p.y); }
float grains(vec2 p) {
  vec2 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(hashOf(i), hashOf(i + vec2(1, 0)), f.x), mix(hashOf(i + vec2(0, 1)), hashOf(i + vec2(1, 1)), f.x), f.y);
}
float metreLine(float v) {
  float w = fwidth(v);
  float d = abs(fract(v - 0.5) - 0.5) / max(w, 1e-6);
  return (1.0 - smoothstep(0.4, 1.3, d)) * (1.0 - smoothstep(0.15, 0.4, w));
}`,
        )
        .replace(
          '#include <color_fragment>',
          `#include <color_fragment>
float level = relief > 1e-4 ? clamp((vGround.z - lowest) / relief, 0.0, 1.0) * 2.0 : 1.3;
diffuseColor.rgb = level < 1.0 ? mix(soil[0], soil[1], level) : mix(soil[1], soil[2], level - 1.0);
float fade = 1.0 - smoothstep(0.004, 0.05, fwidth(vGround.x) + fwidth(vGround.y));
diffuseColor.rgb *= 0.97 + 0.06 * grains(vGround.xy * 9.0) + 0.10 * fade * (grains(vGround.xy * 130.0) - 0.5);
diffuseColor.rgb *= 1.0 - 0.20 * max(metreLine(vGround.x), metreLine(vGround.y));
float pressed = texture2D(rutMap, vPatch).r;
float share = clamp(pressed / rutFull, 0.0, 1.0) * 4.0;
vec3 rutColour = share < 1.0 ? mix(rut[0], rut[1], share) : share < 2.0 ? mix(rut[1], rut[2], share - 1.0)
               : share < 3.0 ? mix(rut[2], rut[3], share - 2.0) : mix(rut[3], rut[4], share - 3.0);
diffuseColor.rgb = mix(diffuseColor.rgb, rutColour, 0.92 * smoothstep(0.0, 0.03 * rutFull, pressed));`,
        )
        .replace(
          '#include <normal_fragment_maps>',
          // Slopes of the rut walls from the map itself, so that they are shaded finer than the mesh.
          `#include <normal_fragment_maps>
float sx = texture2D(rutMap, vPatch + vec2(texelU, 0)).r - texture2D(rutMap, vPatch - vec2(texelU, 0)).r;
float sy = texture2D(rutMap, vPatch + vec2(0, texelV)).r - texture2D(rutMap, vPatch - vec2(0, texelV)).r;
vec3 tilt = vec3(sx / (2.0 * texelX), sy / (2.0 * texelY), 0.0);
normal = normalize(normal + (viewMatrix * vec4(clamp(tilt, -1.5, 1.5), 0.0)).xyz);`,
        );
    };
    return material;
  }

  /** The cut sides of the piece of ground. */
  private skirt(nx: number, ny: number): Mesh {
    const { x0, x1, y0, y1 } = this.size;
    const floor = this.lowest - 0.04 * Math.min(x1 - x0, y1 - y0) - 0.02;
    const rim: [number, number][] = [];
    for (let i = 0; i < nx; ++i) rim.push([x0 + (i / (nx - 1)) * (x1 - x0), y0]);
    for (let j = 1; j < ny; ++j) rim.push([x1, y0 + (j / (ny - 1)) * (y1 - y0)]);
    for (let i = nx - 2; i >= 0; --i) rim.push([x0 + (i / (nx - 1)) * (x1 - x0), y1]);
    for (let j = ny - 2; j >= 0; --j) rim.push([x0, y0 + (j / (ny - 1)) * (y1 - y0)]);
    const position: number[] = [];
    for (let k = 0; k + 1 < rim.length; ++k) {
      const [ax, ay] = rim[k];
      const [bx, by] = rim[k + 1];
      const a = this.height(ax, ay);
      const b = this.height(bx, by);
      position.push(ax, ay, floor, bx, by, floor, bx, by, b, ax, ay, floor, bx, by, b, ax, ay, a);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(position), 3));
    geometry.computeVertexNormals();
    return new Mesh(geometry, new MeshStandardMaterial({ color: '#5d4c3a', roughness: 1 }));
  }
}
