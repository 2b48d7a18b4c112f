// The 3-D view: ground, vehicles, light, camera.
import {
  AmbientLight,
  DirectionalLight,
  HemisphereLight,
  Object3D,
  PCFShadowMap,
  PerspectiveCamera,
  Scene,
  SRGBColorSpace,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { indexBefore, type Run } from './data';
import { GrainsView } from './grains';
import { GroundView } from './ground';
import { VehicleView } from './vehicle';

Object3D.DEFAULT_UP.set(0, 0, 1);

export type ViewName = 'quarter' | 'side' | 'front' | 'top' | 'track';

/** Directions from the vehicle to the camera, and distances in vehicle lengths. */
const views: Record<Exclude<ViewName, 'track'>, [Vector3, number]> = {
  quarter: [new Vector3(-0.72, -1, 0.52).normalize(), 1.75],
  side: [new Vector3(0.03, -1, 0.13).normalize(), 1.55],
  front: [new Vector3(1, -0.12, 0.25).normalize(), 1.6],
  top: [new Vector3(-0.001, 0, 1), 2.1],
};

export class SceneView {
  readonly vehicles: VehicleView[];
  readonly ground: GroundView | null;
  readonly grains: GrainsView[];
  /** [m] sinkage at the end of the colour bar. */
  readonly fullScale: number;
  follow = true;
  showRuts = true;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 0.01, 2000);
  private readonly controls: OrbitControls;
  private readonly sun = new DirectionalLight('#fff1da', 2.9);
  private painted = { vehicle: -1, frame: -1 };
  private followed = new Vector3();
  private paintedRun: number;
  private time = 0;
  private queued = false;

  /** Throws where the browser has no WebGL. */
  constructor(
    private readonly host: HTMLElement,
    runs: Run[],
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    host.append(this.renderer.domElement);

    this.paintedRun = deepest(runs);
    this.vehicles = runs.map((r, k) => new VehicleView(r, runs.length > 1 && k !== this.paintedRun, runs.length > 1));
    const width = 2 * Math.max(0.02, ...this.vehicles.flatMap((v) => v.wheels.map((w) => w.halfWidth)));
    this.fullScale = Math.max(...runs.map(scaleOf));
    const withGround = runs.find((r) => r.header.ground_grid);
    this.ground = withGround ? GroundView.of(withGround, width, this.fullScale) : null;
    if (this.ground) this.scene.add(this.ground.group);
    this.grains = runs.map((r) => GrainsView.of(r)).filter((g) => g !== null);
    for (const g of this.grains) this.scene.add(g.mesh);
    this.lowerGround(true);
    for (const v of this.vehicles) this.scene.add(v.group, v.arrows);

    const size = this.size();
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    const c = this.sun.shadow.camera;
    c.left = c.bottom = -1.1 * size;
    c.right = c.top = 1.1 * size;
    c.near = 0.01 * size;
    c.far = 8 * size;
    this.sun.shadow.normalBias = 0.008 * size;
    this.sun.shadow.bias = -0.0008;
    this.sun.shadow.radius = 3;
    this.scene.add(this.sun, this.sun.target, new HemisphereLight('#dbe8ff', '#9a8260', 1.5), new AmbientLight('#ffffff', 0.3));

    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    this.controls.minDistance = 0.15 * size;
    this.controls.addEventListener('change', () => this.draw());
    // The page scrolls unless the view was clicked.
    this.controls.enableZoom = false;
    this.renderer.domElement.addEventListener('pointerdown', () => (this.controls.enableZoom = true));
    this.renderer.domElement.addEventListener('pointerleave', () => (this.controls.enableZoom = false));
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  get paintedIndex(): number {
    return this.paintedRun;
  }

  paint(run: number): void {
    this.paintedRun = run;
    this.painted = { vehicle: -1, frame: -1 };
    this.show(this.time);
  }

  look(view: ViewName): void {
    const at = this.focus();
    if (view === 'track' && this.ground) {
      const { x0, x1, y0, y1 } = this.ground.size;
      const centre = new Vector3((x0 + x1) / 2, (y0 + y1) / 2, (this.ground.lowest + this.ground.highest) / 2);
      const length = Math.hypot(x1 - x0, y1 - y0);
      this.controls.target.copy(centre);
      this.camera.position.copy(centre).addScaledVector(new Vector3(-0.42, -1, 0.62).normalize(), length * Math.max(0.72, 2 / this.camera.aspect));
      this.follow = false;
    } else {
      const [direction, distance] = views[view === 'track' ? 'quarter' : view];
      this.controls.target.copy(at);
      this.camera.position.copy(at).addScaledVector(direction, distance * this.size() * Math.max(1, 1.3 / this.camera.aspect));
      this.follow = true;
    }
    this.followed.copy(at);
    this.controls.update();
    this.draw();
  }

  show(t: number): void {
    this.time = t;
    for (const v of this.vehicles) v.show(t);
    for (const g of this.grains) g.show(t);
    this.press(t);
    const at = this.focus();
    if (this.follow) {
      const moved = at.clone().sub(this.followed);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
      this.controls.update();
    }
    this.followed.copy(at);
    const size = this.size();
    this.sun.target.position.copy(at);
    this.sun.position.copy(at).addScaledVector(new Vector3(0.55, -0.62, 0.95).normalize(), 3 * size);
    this.draw();
  }

  /** Ask for a picture in the next frame. */
  draw(): void {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => {
      this.queued = false;
      this.renderer.render(this.scene, this.camera);
    });
  }

  setForces(on: boolean): void {
    for (const v of this.vehicles) v.arrows.visible = on && v.group.visible;
    this.draw();
  }

  setGrains(on: boolean): void {
    for (const g of this.grains) g.mesh.visible = on;
    this.lowerGround(on);
    this.draw();
  }

  /** Where grains are shown the smooth ground lies under the tops of the highest ones. */
  private lowerGround(on: boolean): void {
    if (this.ground) this.ground.group.position.z = on ? -1.2 * Math.max(0, ...this.grains.map((g) => g.largest)) : 0;
  }

  setRuts(on: boolean): void {
    this.showRuts = on;
    this.painted = { vehicle: -1, frame: -1 };
    this.ground?.clear();
    this.show(this.time);
  }

  /** Give the graphics memory back: browsers allow few such views at a time. */
  dispose(): void {
    this.queued = true;
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private size(): number {
    // A wheel alone wants some ground around it.
    return Math.max(...this.vehicles.map((v) => (v.wheels.length > 1 ? v.extent : 1.7 * v.extent)));
  }

  private focus(): Vector3 {
    return this.vehicles[this.paintedRun].position(this.time);
  }

  /** Bring the ruts to time t: forward from where they are, or from the start when time went back. */
  private press(t: number): void {
    const v = this.vehicles[this.paintedRun];
    if (!this.ground || !this.showRuts || v.run.poseTime.length === 0) return;
    // Grains leave their own ruts; elsewhere the wheels' circles are pressed in.
    const measured = v.run.header.surface;
    const times = measured ? v.run.read(measured.time) : v.run.poseTime;
    const last = times[0] > t ? -1 : indexBefore(times, t);
    if (this.painted.vehicle !== this.paintedRun || last < this.painted.frame) {
      this.ground.clear();
      this.painted = { vehicle: this.paintedRun, frame: -1 };
    }
    for (let i = this.painted.frame + 1; i <= last; ++i) {
      if (measured) {
        const [x, y, rise] = measured.frames[i].map((ref) => v.run.read(ref));
        this.ground.raise(x, y, measured.side, rise);
      } else {
        for (const p of v.prints(i)) this.ground.press(p);
      }
    }
    this.painted.frame = last;
  }

  private resize(): void {
    const w = this.host.clientWidth;
    const h = this.host.clientHeight;
    if (w === 0 || h === 0) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}

const sinkages = (r: Run) => r.header.wheels.map((w) => r.header.statistics[`${w}.sinkage`]).filter((s) => s);

/** The run whose wheels sink most: its ruts are the ones to look at. */
function deepest(runs: Run[]): number {
  const means = runs.map((r) => Math.max(0, ...sinkages(r).map((s) => s.mean)));
  return Math.max(0, means.indexOf(Math.max(...means)));
}

/** A round end of the colour bar that a single landing does not stretch. */
function scaleOf(r: Run): number {
  const s = Math.max(1e-4, ...sinkages(r).map((k) => Math.min(k.max, k.mean + 3 * k.sd)));
  const digits = Math.pow(10, Math.floor(Math.log10(s)));
  return ([1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((k) => k * digits >= s * 0.999) ?? 10) * digits;
}
