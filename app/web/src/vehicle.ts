// The bodies of one run, the forces on its wheels, and where they press the ground.
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  Quaternion,
  TorusGeometry,
  Vector3,
} from 'three';
import { indexBefore, type Run } from './data';
import type { Print } from './ground';

interface Body {
  name: string;
  group: Group;
  position: Float64Array[];
  orientation: Float64Array[];
}

interface Wheel {
  name: string;
  radius: number;
  halfWidth: number;
  arrow: Group;
  contact?: Float64Array[];
  force?: Float64Array[];
  body?: Body;
}

const up = new Vector3(0, 0, 1);

/** Unit arrow along z: shaft and head are stretched by setArrow. */
function makeArrow(colour: string): Group {
  const material = new MeshBasicMaterial({ color: colour, depthTest: false, transparent: true, opacity: 0.92 });
  const shaft = new Mesh(new CylinderGeometry(1, 1, 1, 10).rotateX(Math.PI / 2).translate(0, 0, 0.5), material);
  const head = new Mesh(new ConeGeometry(1, 1, 14).rotateX(Math.PI / 2).translate(0, 0, -0.5), material);
  shaft.renderOrder = head.renderOrder = 5;
  const g = new Group();
  g.add(shaft, head);
  return g;
}

function setArrow(g: Group, from: Vector3, direction: Vector3, length: number, thickness: number): void {
  g.visible = length > 0.5 * thickness;
  if (!g.visible) return;
  const head = Math.min(0.45 * length, 5 * thickness);
  g.position.copy(from);
  g.quaternion.setFromUnitVectors(up, direction);
  g.children[0].scale.set(thickness, thickness, Math.max(1e-6, length - head));
  g.children[1].scale.set(2.6 * thickness, 2.6 * thickness, head);
  g.children[1].position.z = length;
}

export class VehicleView {
  readonly group = new Group();
  readonly arrows = new Group();
  readonly wheels: Wheel[] = [];
  readonly missing: string[] = [];
  /** Largest extent of the vehicle [m]. */
  readonly extent: number;
  /** [N] that an arrow as long as a wheel is high stands for. */
  readonly forceScale: number;
  private readonly bodies: Body[] = [];

  constructor(
    readonly run: Run,
    ghost: boolean,
    tinted: boolean,
  ) {
    const h = run.header;
    const wheelNames = new Set(h.wheels);
    let widest = 0;
    const centre = new Vector3();
    for (const name of h.bodies) {
      const position = run.vector(`${name}.position`);
      const orientation = run.vector(`${name}.orientation`);
      if (!position || !orientation) continue;
      const body: Body = { name, group: new Group(), position, orientation };
      this.bodies.push(body);
      this.group.add(body.group);
      const shape = this.shape(name);
      const wheel = wheelNames.has(name);
      if (shape) {
        const colour = wheel ? '#3c4046' : this.bodies.length === 1 ? (tinted ? run.colour : '#c9582a') : '#8b929b';
        const material = new MeshStandardMaterial({
          color: ghost ? new Color(colour).lerp(new Color(run.colour), 0.7) : colour,
          roughness: wheel ? 0.85 : 0.5,
          metalness: wheel ? 0 : 0.15,
          flatShading: true,
          side: DoubleSide,
          transparent: ghost,
          opacity: ghost ? 0.42 : 1,
        });
        const mesh = new Mesh(shape, material);
        mesh.castShadow = !ghost;
        mesh.receiveShadow = !ghost;
        body.group.add(mesh);
        shape.computeBoundingSphere();
        widest = Math.max(widest, shape.boundingSphere?.radius ?? 0);
      } else {
        this.missing.push(name);
      }
    }
    for (const name of h.wheels) {
      const body = this.bodies.find((b) => b.name === name);
      const { radius, halfWidth } = this.wheelSize(body);
      const arrow = makeArrow(tinted ? run.colour : '#d3202f');
      this.arrows.add(arrow);
      this.wheels.push({
        name,
        radius,
        halfWidth,
        arrow,
        body,
        contact: run.vector(`${name}.contact_point`),
        force: run.vector(`${name}.force`),
      });
      if (body && radius > 0) body.group.add(this.spokes(radius, halfWidth, ghost));
    }
    // Extent from the first poses: bodies and their sizes.
    const first = this.bodies.map((b) => new Vector3(b.position[0][0], b.position[1][0], b.position[2][0]));
    for (const p of first) centre.add(p.clone().divideScalar(Math.max(1, first.length)));
    this.extent = Math.max(0.2, 2 * widest, ...first.map((p) => 2 * p.distanceTo(centre) + widest));
    const loads = h.wheels.map((w) => h.statistics[`${w}.normal_force`]?.mean ?? 0).filter((f) => f > 0);
    const mean = loads.length > 0 ? loads.reduce((a, b) => a + b) / loads.length : 1;
    const digits = Math.pow(10, Math.floor(Math.log10(mean)));
    this.forceScale = Math.max(1, Math.round(mean / digits)) * digits;
  }

  /** Move everything to time t and aim the arrows. */
  show(t: number): void {
    const time = this.run.poseTime;
    if (time.length === 0) return;
    const i = indexBefore(time, t);
    const j = Math.min(i + 1, time.length - 1);
    const span = time[j] - time[i];
    const w = span > 0 ? Math.min(1, Math.max(0, (t - time[i]) / span)) : 0;
    const mix = (a: Float64Array) => a[i] + w * (a[j] - a[i]);
    const q = new Quaternion();
    for (const b of this.bodies) {
      b.group.position.set(mix(b.position[0]), mix(b.position[1]), mix(b.position[2]));
      const [qw, qx, qy, qz] = b.orientation;
      b.group.quaternion.set(qx[i], qy[i], qz[i], qw[i]).normalize();
      b.group.quaternion.slerp(q.set(qx[j], qy[j], qz[j], qw[j]).normalize(), w);
    }
    for (const wheel of this.wheels) {
      const f = wheel.force && new Vector3(...wheel.force.map(mix));
      const p = wheel.contact && new Vector3(...wheel.contact.map(mix));
      const size = f?.length() ?? 0;
      if (f && p && size > 0 && Number.isFinite(size) && Number.isFinite(p.x))
        setArrow(wheel.arrow, p, f.divideScalar(size), (size / this.forceScale) * 2 * (wheel.radius || 0.1), 0.045 * (wheel.radius || 0.1));
      else wheel.arrow.visible = false;
    }
  }

  /** Place of the first body. */
  position(t: number): Vector3 {
    const b = this.bodies[0];
    if (!b) return new Vector3();
    const time = this.run.poseTime;
    const i = indexBefore(time, t);
    const j = Math.min(i + 1, time.length - 1);
    const span = time[j] - time[i];
    const w = span > 0 ? Math.min(1, Math.max(0, (t - time[i]) / span)) : 0;
    const v = b.position.map((a) => a[i] + w * (a[j] - a[i]));
    return new Vector3(v[0], v[1], v[2]);
  }

  /** What the wheels press at pose frame i. */
  prints(i: number): Print[] {
    const out: Print[] = [];
    const t = this.run.poseTime[i];
    for (const w of this.wheels) {
      if (!w.body || !w.contact || !(w.radius > 0)) continue;
      const sinkage = this.run.at(`${w.name}.sinkage`, t);
      const load = this.run.at(`${w.name}.normal_force`, t);
      if (!(sinkage > 0) || !(load > 0)) continue;
      const o = w.body.orientation;
      const axle = new Vector3(0, 1, 0).applyQuaternion(new Quaternion(o[1][i], o[2][i], o[3][i], o[0][i]));
      const norm = Math.hypot(axle.x, axle.y);
      if (norm < 1e-6) continue;
      // Rolling direction: axle turned by a quarter about z. The wheel's own place, not the centre of pressure ahead of it.
      out.push({
        x: w.body.position[0][i],
        y: w.body.position[1][i],
        ux: axle.y / norm,
        uy: -axle.x / norm,
        radius: w.radius,
        halfWidth: w.halfWidth,
        sinkage,
      });
    }
    return out;
  }

  private shape(name: string): BufferGeometry | null {
    const m = this.run.header.meshes[name];
    if (!m) return null;
    const g = new BufferGeometry();
    g.setAttribute('position', new BufferAttribute(Float32Array.from(this.run.read(m.vertices)), 3));
    g.setIndex(new BufferAttribute(Uint32Array.from(this.run.read(m.triangles)), 1));
    return g;
  }

  private wheelSize(body: Body | undefined): { radius: number; halfWidth: number } {
    const mesh = body && this.run.header.meshes[body.name];
    if (!mesh) return { radius: 0, halfWidth: 0 };
    const v = this.run.read(mesh.vertices);
    let radius = 0;
    let halfWidth = 0;
    for (let k = 0; k < v.length; k += 3) {
      radius = Math.max(radius, Math.hypot(v[k], v[k + 2]));
      halfWidth = Math.max(halfWidth, Math.abs(v[k + 1]));
    }
    return { radius, halfWidth };
  }

  /** Rim and spokes on both sides, one spoke in another colour, so that one sees the wheel turn. */
  private spokes(radius: number, halfWidth: number, ghost: boolean): Group {
    const g = new Group();
    const paint = (color: string) =>
      new MeshStandardMaterial({ color, roughness: 0.6, metalness: 0.2, transparent: ghost, opacity: ghost ? 0.5 : 1 });
    const light = paint('#c3c8ce');
    const marked = paint('#f2b418');
    const depth = 0.04 * radius;
    for (const side of [-1, 1]) {
      const y = side * (halfWidth + 0.3 * depth);
      const rim = new Mesh(new TorusGeometry(0.74 * radius, 0.035 * radius, 6, 40).rotateX(Math.PI / 2), light);
      const hub = new Mesh(new CylinderGeometry(0.17 * radius, 0.17 * radius, 1.6 * depth, 20), light);
      rim.position.y = hub.position.y = y;
      g.add(rim, hub);
      for (let k = 0; k < 5; ++k) {
        const spoke = new Mesh(new BoxGeometry(0.6 * radius, depth, 0.085 * radius).translate(0.42 * radius, 0, 0), k === 0 ? marked : light);
        spoke.position.y = y;
        spoke.rotation.y = (2 * Math.PI * k) / 5;
        g.add(spoke);
      }
    }
    return g;
  }
}
