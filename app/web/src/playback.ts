// The 3-D view with its controls and legend.
import type { Clock } from './clock';
import { gradient, rutRamp, soilRamp } from './colours';
import type { Run } from './data';
import { SceneView, type ViewName } from './scene';
import { el, fixed, num } from './text';

const icon = (path: string): string => `<svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true"><path d="${path}"/></svg>`;
const playIcon = icon('M4 2.5v11l9.5-5.5z');
const pauseIcon = icon('M3.5 2.5h3v11h-3zM9.5 2.5h3v11h-3z');

function toggle(label: string, on: boolean, act: (on: boolean) => void): HTMLElement {
  const input = el('input', { type: 'checkbox' });
  input.checked = on;
  input.addEventListener('change', () => act(input.checked));
  return el('label', { class: 'toggle' }, input, label);
}

/** What one reads off while the vehicle moves. */
function readout(run: Run, t: number): string {
  const mean = (name: string) => {
    const v = run.header.wheels.map((w) => run.at(`${w}.${name}`, t)).filter(Number.isFinite);
    return v.length > 0 ? v.reduce((a, b) => a + b) / v.length : NaN;
  };
  const parts: string[] = [];
  const speed = run.at('vehicle.speed', t);
  if (Number.isFinite(speed)) parts.push(`${fixed(speed, 2)} m/s`);
  const sinkage = mean('sinkage');
  if (Number.isFinite(sinkage)) parts.push(`sinkage ${fixed(1e3 * sinkage, 1)} mm`);
  const slip = mean('slip');
  if (Number.isFinite(slip)) parts.push(`slip ${fixed(100 * slip, 0)} %`);
  return parts.join(' \u00b7 ');
}

export interface Playback {
  root: HTMLElement;
  /** Once the page holds it. */
  mount(): void;
  dispose(): void;
}

export function playback(runs: Run[], clock: Clock): Playback {
  const stage = el('div', { class: 'stage' });
  const hud = el('div', { class: 'hud' });
  const legend = el('div', { class: 'legend' });
  const play = el('button', { class: 'play', title: 'Play or pause (space)' });
  const slider = el('input', { type: 'range', min: String(clock.begin), max: String(clock.end), step: '0.001', 'aria-label': 'time' });
  const timeText = el('output', { class: 'time' });
  const speed = el('select', { title: 'Playback speed', 'aria-label': 'playback speed' });
  for (const s of [0.1, 0.25, 0.5, 1, 2, 4, 8]) speed.append(el('option', { value: String(s), ...(s === 1 ? { selected: '' } : {}) }, `${s}\u00d7`));
  const options = el('div', { class: 'options' });
  const controls = el('div', { class: 'controls' }, play, slider, timeText, speed, options);
  const root = el('section', { class: 'playback' }, el('div', { class: 'view' }, stage, hud, legend), controls);

  play.addEventListener('click', () => clock.toggle());
  slider.addEventListener('input', () => clock.seek(Number(slider.value)));
  speed.addEventListener('change', () => (clock.speed = Number(speed.value)));
  document.addEventListener('keydown', (e) => {
    if (e.code !== 'Space' || /^(INPUT|SELECT|BUTTON|SUMMARY)$/.test((e.target as HTMLElement).tagName)) return;
    e.preventDefault();
    clock.toggle();
  });

  let shown: boolean | null = null;
  const update = () => {
    if (shown !== clock.playing) play.innerHTML = (shown = clock.playing) ? pauseIcon : playIcon;
    slider.value = String(clock.t);
    timeText.textContent = `${clock.t.toFixed(2)} / ${clock.end.toFixed(2)} s`;
    lines.forEach(([run, span]) => (span.textContent = readout(run, clock.t)));
  };
  const lines: [Run, HTMLElement][] = [];
  for (const run of runs) {
    const span = el('span');
    lines.push([run, span]);
    const row = el('div', { class: 'row' });
    if (runs.length > 1) row.append(el('i', { class: 'swatch', style: `background:${run.colour}` }), el('b', {}, run.label), ' ');
    row.append(span);
    hud.append(row);
  }

  let drawn: SceneView | null = null;
  const mount = () => {
    clock.listen(update);
    update();
    let scene: SceneView;
    try {
      drawn = scene = new SceneView(stage, runs);
    } catch {
      stage.replaceChildren(
        el('p', { class: 'nogl' }, 'This browser offers no WebGL, so the 3-D playback is missing. The time slider still moves the cursor of the plots.'),
      );
      legend.remove();
      stage.parentElement?.classList.add('small');
      return;
    }
    const forces = toggle('forces', true, (on) => scene.setForces(on));
    const follow = el('input', { type: 'checkbox' });
    follow.checked = true;
    follow.addEventListener('change', () => (scene.follow = follow.checked));
    options.append(el('label', { class: 'toggle' }, follow, 'follow'), forces);
    if (scene.ground) options.append(toggle('ruts', true, (on) => scene.setRuts(on)));
    if (scene.grains.length > 0) options.append(toggle('grains', true, (on) => scene.setGrains(on)));
    const views: [ViewName, string][] = [['quarter', 'oblique'], ['side', 'side'], ['front', 'front'], ['top', 'top']];
    if (scene.ground) views.push(['track', 'whole ground']);
    const buttons = el('div', { class: 'views' });
    for (const [name, label] of views) {
      const b = el('button', {}, label);
      b.addEventListener('click', () => {
        scene.look(name);
        follow.checked = scene.follow;
      });
      buttons.append(b);
    }
    options.append(buttons);

    if (runs.length > 1) {
      const rows = hud.querySelectorAll('.row');
      runs.forEach((run, k) => {
        const box = el('input', { type: 'checkbox', title: 'Show this run', 'aria-label': `show ${run.label}` });
        box.checked = true;
        box.addEventListener('change', () => {
          scene.vehicles[k].group.visible = scene.vehicles[k].arrows.visible = box.checked;
          scene.draw();
        });
        rows[k].prepend(box);
      });
      const select = el('select', { 'aria-label': 'run whose ruts are shown' });
      runs.forEach((r, k) => select.append(el('option', { value: String(k), ...(k === scene.paintedIndex ? { selected: '' } : {}) }, r.label)));
      select.addEventListener('change', () => scene.paint(Number(select.value)));
      options.append(el('label', { class: 'toggle' }, 'ruts of', select));
    }

    const bar = (label: string, ramp: string[], from: string, to: string) =>
      el('div', { class: 'bar' }, el('span', { class: 'name' }, label), el('span', {}, from), el('i', { style: `background:${gradient(ramp)}` }), el('span', {}, to));
    if (scene.ground) {
      legend.append(bar('sinkage', rutRamp, '0', `${num(1e3 * scene.fullScale, 2)} mm`));
      const relief = scene.ground.highest - scene.ground.lowest;
      if (relief > 1e-4) {
        const mm = (z: number) => fixed(1e3 * z, 0);
        legend.append(bar('height', soilRamp, mm(scene.ground.lowest), `${mm(scene.ground.highest)} mm`));
      }
    }
    const main = scene.vehicles[scene.paintedIndex];
    if (main.wheels.some((w) => w.force)) {
      legend.append(el('div', {}, `arrow as long as a wheel is high: ${num(main.forceScale, 2)} N`));
    }
    if (scene.ground) legend.append(el('div', {}, 'lines on the ground every 1 m'));
    if (main.missing.length > 0) legend.append(el('div', {}, `no shape stored for ${main.missing.join(', ')}`));

    clock.listen(() => scene.show(clock.t));
    scene.show(clock.t);
    root.dataset.playback = 'drawn';
    const asked = /[#&]view=(\w+)/.exec(location.hash)?.[1];
    scene.look(views.some(([v]) => v === asked) ? (asked as ViewName) : 'quarter');
    follow.checked = scene.follow;
  };
  return { root, mount, dispose: () => drawn?.dispose() };
}
