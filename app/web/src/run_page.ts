// Sections of one run or of several runs of the same kind.
import { Clock } from './clock';
import { wheelColours } from './colours';
import { interpolate, type Run, type Statistics } from './data';
import { playback } from './playback';
import { Charts, type ChartOptions, type Line } from './plots';
import { details, el, num, section, table, words } from './text';

interface WheelPlot {
  channel: string;
  title: string;
  unit: string;
  factor: number;
}

export const wheelPlots: WheelPlot[] = [
  { channel: 'drawbar_pull', title: 'Drawbar pull', unit: 'N', factor: 1 },
  { channel: 'driving_torque', title: 'Driving torque', unit: 'N\u00b7m', factor: 1 },
  { channel: 'sinkage', title: 'Sinkage', unit: 'mm', factor: 1e3 },
  { channel: 'slip', title: 'Slip', unit: '\u2013', factor: 1 },
  { channel: 'normal_force', title: 'Wheel load', unit: 'N', factor: 1 },
  { channel: 'side_force', title: 'Side force', unit: 'N', factor: 1 },
];

const degrees = 180 / Math.PI;

interface VehiclePlot {
  title: string;
  unit: string;
  channels: [string, string, number][];
}

const vehiclePlots: VehiclePlot[] = [
  { title: 'Speed', unit: 'm/s', channels: [['vehicle.speed', 'speed', 1]] },
  { title: 'Motor power', unit: 'W', channels: [['vehicle.power', 'power', 1]] },
  { title: 'Pitch and roll', unit: '\u00b0', channels: [['vehicle.pitch', 'pitch', degrees], ['vehicle.roll', 'roll', degrees]] },
  { title: 'Vertical acceleration', unit: 'm/s\u00b2', channels: [['vehicle.vertical_acceleration', 'acceleration', 1]] },
];

const scaled = (y: Float64Array, factor: number) => (factor === 1 ? y : y.map((v) => v * factor));

/** Mean over the wheels of a channel. */
function wheelMean(run: Run, channel: string): Float64Array | undefined {
  const all = run.header.wheels.map((w) => run.series(`${w}.${channel}`)).filter((y) => y !== undefined);
  if (all.length === 0) return undefined;
  return all[0].map((_, i) => all.reduce((s, y) => s + y[i], 0) / all.length);
}

function wheelLines(runs: Run[], p: WheelPlot, choice: string): Line[] {
  const lines: Line[] = [];
  const several = runs.length > 1;
  for (const run of runs) {
    const names = choice === 'all' ? run.header.wheels : choice === 'mean' ? [] : [choice];
    if (choice === 'mean') {
      const y = wheelMean(run, p.channel);
      if (y) lines.push({ label: several ? run.label : 'mean of the wheels', x: run.time, y: scaled(y, p.factor), colour: run.colour });
    }
    names.forEach((w) => {
      const y = run.series(`${w}.${p.channel}`);
      const k = run.header.wheels.indexOf(w);
      if (!y) return;
      lines.push({
        label: several ? (choice === 'all' ? `${run.label}: ${words(w)}` : run.label) : words(w),
        x: run.time,
        y: scaled(y, p.factor),
        colour: several ? run.colour : wheelColours[k % wheelColours.length],
        dash: several && choice === 'all' && k % 2 === 1 ? [5, 4] : undefined,
      });
    });
  }
  return lines;
}

/** Motor and battery energy over distance, both divided by the distance so far; the first steps would divide by almost nothing. */
function energyPerMetre(run: Run, channel: string): { x: number[]; y: number[] } | null {
  const d = run.series('vehicle.distance');
  const e = run.series(channel);
  if (!d || !e) return null;
  const total = d[d.length - 1];
  const from = Math.max(0.1, 0.03 * total);
  const x: number[] = [];
  const y: number[] = [];
  let before = -Infinity;
  for (let i = 0; i < d.length; ++i)
    if (d[i] >= from && d[i] > before) {
      x.push((before = d[i]));
      y.push(e[i] / d[i]);
    }
  return x.length > 1 ? { x, y } : null;
}

function addPlots(charts: Charts, runs: Run[], grid: HTMLElement): void {
  const several = runs.length > 1;
  const add = (o: ChartOptions, lines: Line[]) => lines.length > 0 && grid.append(charts.add(o, lines));
  for (const p of vehiclePlots) {
    const lines: Line[] = [];
    for (const run of runs)
      p.channels.forEach(([name, label, factor], k) => {
        const y = run.series(name);
        if (!y) return;
        const text = several ? (p.channels.length > 1 ? `${run.label}: ${label}` : run.label) : label;
        lines.push({
          label: text,
          x: run.time,
          y: scaled(y, factor),
          colour: several ? run.colour : wheelColours[k],
          dash: several && k > 0 ? [5, 4] : undefined,
        });
      });
    add({ title: p.title, unit: p.unit, xLabel: 'time [s]', axis: 'time' }, lines);
  }

  const energy: Line[] = [];
  for (const run of runs)
    for (const [k, [channel, label]] of [['vehicle.motor_energy', 'motors'], ['vehicle.battery_energy', 'battery']].entries()) {
      const e = energyPerMetre(run, channel);
      if (e) energy.push({ label: several ? `${run.label}: ${label}` : label, ...e, colour: several ? run.colour : wheelColours[k], dash: k > 0 ? [5, 4] : undefined });
    }
  const first = runs[0];
  const distance = first.series('vehicle.distance');
  add(
    {
      title: 'Energy per metre driven so far',
      unit: 'J/m',
      xLabel: 'distance [m]',
      axis: 'other',
      timeToX: distance && ((t) => interpolate(first.time, distance, t)),
      xToTime: distance && ((x) => interpolate(distance, first.time, x)),
    },
    energy,
  );

  const spectra: Line[] = [];
  let note = '';
  for (const run of runs) {
    const s = run.header.spectrum;
    if (!s) continue;
    const x: number[] = [];
    const y: number[] = [];
    s.density.forEach((g, k) => {
      if (k > 0 && g > 0) {
        x.push(k * s.resolution);
        y.push(g);
      }
    });
    // Below a millionth of the peak it is noise of the storage: keep the decades that say something.
    const floor = 1e-7 * Math.max(...y);
    spectra.push({ label: several ? run.label : 'density', x, y: y.map((g) => Math.max(g, floor)), colour: several ? run.colour : wheelColours[0] });
    note = `Welch, Hann window, one-sided, ${s.segments} segments of ${num(1 / s.resolution, 3)} s with half overlap, mean removed.`;
  }
  add(
    { title: 'Power spectral density of vertical acceleration', unit: '(m/s\u00b2)\u00b2/Hz', xLabel: 'frequency [Hz]', axis: 'other', logarithmic: true, note },
    spectra,
  );
}

/** Wheel plots with a choice of wheel. */
function wheelSection(charts: Charts, runs: Run[]): HTMLElement | null {
  const names = [...new Set(runs.flatMap((r) => r.header.wheels))];
  if (names.length === 0) return null;
  const grid = el('div', { class: 'grid' });
  let choice = names.length === 1 ? names[0] : runs.length > 1 ? 'mean' : 'all';
  const select = el('select', { 'aria-label': 'wheel' });
  for (const [value, label] of [['all', 'every wheel'], ['mean', 'mean of the wheels'], ...names.map((n) => [n, words(n)])])
    select.append(el('option', { value, ...(value === choice ? { selected: '' } : {}) }, label));
  const draw = () => {
    for (const p of wheelPlots) {
      const lines = wheelLines(runs, p, choice);
      // Without steering there is hardly a side force: leave the empty plot out.
      if (lines.length === 0 || (p.channel === 'side_force' && lines.every((l) => Array.from(l.y).every((v) => !(Math.abs(v) > 1e-3))))) continue;
      grid.append(charts.add({ title: p.title, unit: p.unit, xLabel: 'time [s]', axis: 'time' }, lines));
    }
  };
  draw();
  select.addEventListener('change', () => {
    choice = select.value;
    charts.remove(grid);
    draw();
    charts.mount();
  });
  const head = names.length > 1 ? el('div', { class: 'choice' }, el('label', { class: 'toggle' }, 'wheels', select)) : null;
  return section('Wheels on the soil', 'Click into a plot to move the time, drag to zoom, double-click to zoom out.', head, grid);
}

const ledgerRows: [string, string][] = [
  ['energy.motor', 'work of the motors'],
  ['energy.soil_work', 'work of the soil on the wheels'],
  ['energy.kinetic', 'kinetic energy'],
  ['energy.potential', 'potential energy'],
  ['energy.spring', 'stored in springs'],
  ['energy.damper', 'dissipated in dampers'],
  ['energy.soil_stored', 'stored in the soil'],
  ['energy.soil_dissipated', 'dissipated in the soil'],
  ['energy.implicit_correction', 'implicit contact correction'],
  ['energy.integration', 'time integration'],
  ['energy.joints', 'joint constraints'],
  ['energy.residual', 'residual'],
];

function ledger(charts: Charts, runs: Run[]): HTMLElement | null {
  const last = (run: Run, name: string) => {
    const y = run.series(name);
    return y && y.length > 0 ? y[y.length - 1] : NaN;
  };
  const rows = ledgerRows.filter(([c]) => runs.some((r) => r.header.channels[c]));
  if (rows.length === 0) return null;
  const most = Math.max(1e-12, ...rows.flatMap(([c]) => runs.map((r) => Math.abs(last(r, c))).filter(Number.isFinite)));
  const bar = (v: number, colour: string) => {
    const share = Math.min(1, Math.abs(v) / most) * 50;
    const style = `width:${share}%;left:${v < 0 ? 50 - share : 50}%;background:${colour}`;
    return el('div', { class: 'ledger-bar' }, el('i', { style }));
  };
  const several = runs.length > 1;
  const body = rows.map(([c, label]) => [
    label,
    ...runs.flatMap((r) => {
      const v = last(r, c);
      return [el('span', { class: 'number' }, num(v)), bar(v, several ? r.colour : c === 'energy.residual' ? 'var(--bad)' : 'var(--accent)')];
    }),
  ]);
  const head = ['at the end [J]', ...runs.flatMap((r) => [several ? r.label : 'energy', ''])];

  const lines: Line[] = [];
  for (const run of runs)
    for (const [k, [c, label]] of rows.entries()) {
      const y = run.series(c);
      const wanted = several ? ['energy.motor', 'energy.soil_dissipated', 'energy.residual'] : null;
      if (!y || (wanted && !wanted.includes(c))) continue;
      if (!wanted && !(run.header.statistics[c].rms > 1e-4 * most) && c !== 'energy.residual') continue;
      lines.push({
        label: several ? `${run.label}: ${label}` : label,
        x: run.time,
        y,
        colour: several ? run.colour : c === 'energy.residual' ? '#cf3552' : wheelColours[k % wheelColours.length],
        dash: c === 'energy.residual' ? [4, 3] : several && c !== 'energy.motor' ? [8, 4] : undefined,
      });
    }
  const worst = runs
    .map(({ label, header: { summary: s } }) => {
      const of = `${s.energy_yardstick}, ${num(s.energy_yardstick_J)} J`;
      const share = s.energy_residual_ratio === null ? `${num(s.energy_residual_J)} J (next to no work: ${of})` : `${percent(s.energy_residual_ratio)} % of the ${of}`;
      return `${several ? `${label}: ` : ''}${share}`;
    })
    .join('; ');
  return section(
    'Energy ledger',
    `Every entry comes from its own formula; the residual is what does not add up. Residual at the end: ${worst}.`,
    el('div', { class: 'grid' }, el('div', { class: 'card' }, table(head, body, 'ledger')), charts.add({ title: 'Energy', unit: 'J', xLabel: 'time [s]', axis: 'time' }, lines)),
  );
}

interface StatisticsRow {
  label: string;
  unit: string;
  factor: number;
  of: (run: Run) => Statistics | null;
}

function statisticsRows(): StatisticsRow[] {
  const rows: StatisticsRow[] = wheelPlots.map((p) => ({
    label: `${p.title}, all wheels`,
    unit: p.unit,
    factor: p.factor,
    of: (run) => {
      const all = run.header.wheels.map((w) => run.header.statistics[`${w}.${p.channel}`]).filter((s) => s);
      if (all.length === 0) return null;
      const mean = all.reduce((s, x) => s + x.mean, 0) / all.length;
      const square = all.reduce((s, x) => s + x.rms * x.rms, 0) / all.length;
      return {
        mean,
        rms: Math.sqrt(square),
        sd: Math.sqrt(Math.max(0, square - mean * mean)),
        min: Math.min(...all.map((x) => x.min)),
        max: Math.max(...all.map((x) => x.max)),
      };
    },
  }));
  for (const p of vehiclePlots)
    for (const [channel, label, factor] of p.channels)
      rows.push({ label: p.channels.length > 1 ? label[0].toUpperCase() + label.slice(1) : p.title, unit: p.unit, factor, of: (run) => run.header.statistics[channel] ?? null });
  return rows;
}

function statisticsSection(runs: Run[]): HTMLElement {
  const several = runs.length > 1;
  const rows: (string | Node)[][] = [];
  const right = (s: string) => el('span', { class: 'number' }, s);
  for (const row of statisticsRows()) {
    const all = runs.map((r) => row.of(r));
    if (!all.some((s) => s)) continue;
    const first = all[0];
    runs.forEach((run, k) => {
      const s = all[k];
      if (!s) return;
      const values = [s.mean, s.rms, s.sd, s.min, s.max].map((v) => right(num(v * row.factor)));
      const label = el('span', { class: 'quantity' }, k === 0 || !first ? row.label : '', ' ', k === 0 ? el('span', { class: 'unit' }, `[${row.unit}]`) : null);
      if (!several) {
        rows.push([label, ...values]);
        return;
      }
      const difference = k === 0 || !first ? ['', ''] : [(s.mean - first.mean) * row.factor, (s.rms - first.rms) * row.factor].map((v) => (v > 0 ? '+' : '') + num(v));
      const name = el('span', {}, el('i', { class: 'swatch', style: `background:${run.colour}` }), run.label);
      rows.push([label, name, ...values, right(difference[0]), right(difference[1])]);
    });
  }
  const head = several
    ? ['quantity', 'run', 'mean', 'rms', 'sd', 'least', 'greatest', 'mean \u2212 first', 'rms \u2212 first']
    : ['quantity', 'mean', 'rms', 'sd', 'least', 'greatest'];
  return section('Statistics', 'Over every recorded frame; sd is the standard deviation in time (and over the wheels).', el('div', { class: 'card' }, table(head, rows, 'statistics')));
}

/** How the computing time splits. */
export function timing(runs: Run[]): HTMLElement | null {
  const host = el('div', { class: 'card' });
  const colours = { Bullet: '#2f6fdf', terrain: '#e0701a', output: '#1f9d66', other: '#9aa1ab' };
  for (const run of runs) {
    const t = run.header.summary.timing;
    const wall = t.wall_s ?? 0;
    if (!(wall > 0)) continue;
    const parts: Record<string, number> = { Bullet: t.bullet_s ?? 0, terrain: t.terrain_s ?? 0, output: t.output_s ?? 0 };
    parts.other = Math.max(0, wall - parts.Bullet - parts.terrain - parts.output);
    const total = Object.values(parts).reduce((a, b) => a + b);
    const bar = el('div', { class: 'split' });
    const names = el('div', { class: 'split-names' });
    for (const [name, s] of Object.entries(parts)) {
      const share = (100 * s) / total;
      const colour = colours[name as keyof typeof colours];
      bar.append(el('i', { style: `width:${share}%;background:${colour}`, title: `${name}: ${num(s)} s` }));
      names.append(el('span', {}, el('i', { class: 'swatch', style: `background:${colour}` }), `${name} ${num(s)} s (${share.toFixed(0)} %)`));
    }
    const rtf = run.header.summary.real_time_factor;
    host.append(
      el('p', {}, runs.length > 1 ? el('b', {}, `${run.label}: `) : null, `${num(run.header.summary.simulated_s)} s simulated in ${num(wall)} s`, rtf ? `, ${num(rtf)} times real time` : ''),
      bar,
      names,
    );
  }
  return host.childElementCount > 0 ? section('Computing time', '', host) : null;
}

export function assumptions(runs: { header: { assumptions: { file: string; key: string; value: string; why: string }[] } }[]): HTMLElement | null {
  const seen = new Map<string, string[]>();
  for (const r of runs)
    for (const a of r.header.assumptions) seen.set(`${a.file} ${a.key}`, [a.key, a.value, a.why, a.file.replace(/^.*\//, '')].map((s) => String(s ?? '')));
  if (seen.size === 0) return null;
  return details(`${seen.size} assumption${seen.size > 1 ? 's' : ''}: values that the sources do not give, and what the model simplifies`, table(['of', 'assumed', 'why', 'file'], [...seen.values()]));
}

export function warnings(items: string[]): HTMLElement | null {
  if (items.length === 0) return null;
  return el('div', { class: 'warnings', role: 'status' }, ...items.map((w) => el('p', {}, w)));
}

function sentence(run: Run): string {
  const s = run.header.summary;
  const mass = run.header.total_mass_kg;
  const where = [run.header.ground ? `over ${run.header.ground}` : '', run.header.soil ? `on ${words(run.header.soil)}` : ''].filter(Boolean).join(' ');
  let text = mass ? `The ${num(mass)} kg vehicle ` : 'The vehicle ';
  text += s.distance_m !== null ? `drove ${num(s.distance_m)} m in ${num(s.simulated_s)} s` : `was simulated for ${num(s.simulated_s)} s`;
  if (s.mean_speed_mps !== null) text += ` (mean ${num(s.mean_speed_mps)} m/s)`;
  text += `${where ? ` ${where}` : ''}, soil model ${run.header.terrain}.`;
  if (s.max_sinkage_m !== null && s.max_sinkage_m > 0) text += ` It sank at most ${num(1e3 * s.max_sinkage_m)} mm${s.deepest_wheel ? ` (${words(s.deepest_wheel)} wheel)` : ''}`;
  if (s.energy_per_metre !== null) text += `${s.max_sinkage_m ? ' and' : ' It'} spent ${num(s.energy_per_metre)} J of motor work per metre`;
  if (!text.endsWith('.')) text += '.';
  if (s.real_time_factor !== null) text += ` Computed at ${num(s.real_time_factor)} times real time.`;
  return text;
}

/** A share in percent; below a thousandth of a percent digits say nothing. */
function percent(ratio: number | null): string {
  if (ratio === null) return 'n/a';
  return Math.abs(ratio) < 1e-5 ? '< 0.001' : num(100 * ratio, 2);
}

function cards(run: Run): HTMLElement {
  const s = run.header.summary;
  const rms = run.header.statistics['vehicle.vertical_acceleration']?.rms;
  const items: [string, string, string][] = [
    ['distance', num(s.distance_m), 'm'],
    ['mean speed', num(s.mean_speed_mps), 'm/s'],
    ['greatest sinkage', num(s.max_sinkage_m === null ? null : 1e3 * s.max_sinkage_m), 'mm'],
    ['motor work', num(s.energy_per_metre), 'J/m'],
    ['battery', num(s.battery_per_metre), 'J/m'],
    ['vertical acceleration, rms', num(rms), 'm/s\u00b2'],
    [`energy residual of the ${s.energy_yardstick.replace('positive ', '')}`, percent(s.energy_residual_ratio), '%'],
    ['real-time factor', num(s.real_time_factor), '\u00d7'],
  ];
  return el(
    'div',
    { class: 'numbers' },
    ...items.filter(([, v]) => v !== 'n/a').map(([label, value, unit]) => el('div', {}, el('strong', {}, value, ' ', el('small', {}, unit)), el('span', {}, label))),
  );
}

function about(run: Run): HTMLElement {
  const h = run.header;
  const facts: [string, string][] = [
    ['folder', h.folder],
    ['soil model', h.terrain],
    ['soil', h.soil],
    ['ground', h.ground],
    ['vehicle mass', h.total_mass_kg ? `${num(h.total_mass_kg, 4)} kg` : ''],
    ['gravity', h.gravity ? `${num(h.gravity, 4)} m/s\u00b2` : ''],
    ['frames', h.frame_rate ? `${h.frames} at ${num(h.frame_rate, 4)} Hz${h.thinned ? '; curves show the least and greatest of each short interval' : ''}` : String(h.frames)],
    ['joint drift', `${num(1e3 * h.summary.joint_drift_m, 2)} mm at most`],
    ['seed', String(h.seed)],
    ['status', h.status],
    ['end state', h.end_state_hash],
    ['grouser', h.version],
  ];
  return el(
    'div',
    {},
    table(['', ''], facts.filter(([, v]) => v).map(([k, v]) => [k, v]), 'facts'),
    h.scenario ? details('Scenario as it ran', el('pre', {}, h.scenario)) : null,
  );
}

export interface Page {
  charts: { restyle(): void };
  mount(): void;
}

/** All sections of a run or comparison. `onlyCurves` leaves out what a rig case does not have. */
export function runPage(host: HTMLElement, runs: Run[]): Page {
  const begin = Math.min(...runs.map((r) => r.time[0] ?? 0));
  const end = Math.max(...runs.map((r) => r.time[r.time.length - 1] ?? 0));
  const clock = new Clock(begin, end);
  const charts = new Charts(clock);
  const several = runs.length > 1;

  const lead = el('div', { class: 'lead' });
  for (const run of runs) {
    const name = el('h3', {}, el('i', { class: 'swatch', style: `background:${run.colour}` }), run.label);
    lead.append(el('div', { class: 'card' }, several ? name : null, el('p', { class: 'sentence' }, sentence(run)), cards(run)));
  }
  if (several) lead.classList.add('several');
  const notes = runs.flatMap((r) => r.header.warnings.map((w) => (several ? `${r.label}: ${w}` : w)));
  const put = (...e: (Node | null)[]) => e.forEach((x) => x && host.append(x));
  put(lead, warnings(notes));
  if (runs.some((r) => r.time.length > 1)) {
    const view = playback(runs, clock);
    put(view.root);
    const vehicleGrid = el('div', { class: 'grid' });
    addPlots(charts, runs, vehicleGrid);
    put(wheelSection(charts, runs));
    if (vehicleGrid.childElementCount > 0) put(section('Vehicle', '', vehicleGrid));
    put(ledger(charts, runs), statisticsSection(runs), timing(runs));
    put(section('About', '', assumptions(runs), ...runs.map((r) => (several ? details(r.label, about(r)) : about(r)))));
    return {
      charts,
      mount: () => {
        charts.mount();
        view.mount();
        const t = /[#&]t=([\d.]+)/.exec(location.hash)?.[1];
        // Open a little into the run, where there is something to see.
        clock.seek(t ? Number(t) : begin + 0.4 * (end - begin));
        const speed = /[#&]play=([\d.]+)/.exec(location.hash)?.[1];
        if (speed) {
          clock.speed = Number(speed) || 1;
          clock.toggle();
        }
      },
    };
  }
  put(section('About', '', assumptions(runs), ...runs.map((r) => about(r))));
  return { charts, mount: () => charts.mount() };
}

