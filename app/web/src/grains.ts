// Soil that is made of grains: those near the wheels, as spheres, from one recorded set to the next.
import { Color, IcosahedronGeometry, InstancedMesh, Matrix4, MeshStandardMaterial } from 'three';
import { indexBefore, type Run } from './data';
import { soilRamp } from './colours';

export class GrainsView {
  readonly mesh: InstancedMesh;
  /** [m] */
  readonly largest: number;
  private readonly time: Float64Array;
  private shown = -1;

  static of(run: Run): GrainsView | null {
    return run.header.points ? new GrainsView(run) : null;
  }

  private constructor(private readonly run: Run) {
    const points = run.header.points!;
    this.time = run.read(points.time);
    const most = Math.max(...points.frames.map((f) => f[0].n));
    this.mesh = new InstancedMesh(new IcosahedronGeometry(1, 1), new MeshStandardMaterial({ roughness: 0.95 }), most);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.largest = run.read(points.frames[0][3]).reduce((a, b) => Math.max(a, b), 0);
    const soil = soilRamp.map((c) => new Color(c));
    const tint = new Color();
    // Grains keep no number from set to set: the shade tells neighbours apart, no more.
    for (let i = 0; i < most; ++i) this.mesh.setColorAt(i, tint.copy(soil[i % 2]).lerp(soil[2], ((i * 7919) % 97) / 97));
  }

  show(t: number): void {
    const k = indexBefore(this.time, t);
    if (k === this.shown) return;
    this.shown = k;
    const [x, y, z, r] = this.run.header.points!.frames[k].map((ref) => this.run.read(ref));
    const m = new Matrix4();
    for (let i = 0; i < x.length; ++i) this.mesh.setMatrixAt(i, m.makeScale(r[i], r[i], r[i]).setPosition(x[i], y[i], z[i]));
    this.mesh.count = x.length;
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
