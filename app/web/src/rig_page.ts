// Sections of the single-wheel rig: steady values against slip, measured points, errors, and the time series of each case.
import { Clock } from './clock';
import { runColours } from './colours';
import { Run, type Block, type Cell, type RigHeader, type Table } from './data';
import { playback, type Playback } from './playback';
import { Charts, type Line } from './plots';
import { assumptions, warnings, wheelPlots, type Page } from './run_page';
import { details, el, num, section, table, unitText, words } from './text';

export interface Rig {
  header: RigHeader;
  block: Block;
  label: string;
  colour: string;
}

interface Column {
  index: number;
  channel: string;
  unit: string;
  spread: boolean; // standard deviation or reading error of the channel
}

const units = ['Nm', 'mm', 'deg', 'rad', 'J', 'N', 'm', 'W'];

/** "drawbar_pull_sd_N" -> channel drawbar_pull, unit N, spread. Short names of older tables are known too. */
function columnsOf(t: Table): Column[] {
  const synonyms: Record<string, string> = { drawbar: 'drawbar_pull', torque: 'driving_torque', side: 'side_force', lateral_force: 'side_force' };
  return t.columns.flatMap((name, index) => {
    const unit = units.find((u) => name.endsWith(`_${u}`));
    if (!unit) return [];
    let channel = name.slice(0, -unit.length - 1);
    const spread = /_(sd|error|read_error)$/.test(channel);
    channel = channel.replace(/_(sd|error|read_error)$/, '').replace(/_mean$/, '');
    return [{ index, channel: synonyms[channel] ?? channel, unit, spread }];
  });
}

const number = (c: Cell): number => (typeof c === 'number' ? c : NaN);

interface Curve {
  group: string;
  slip: number[];
  value: number[];
  error: number[];
  /** Half width of the model's own 90 % bar. */
  model: number[];
}

/** One curve per group of rows, sorted by slip. */
function curves(t: Table, channel: string): Curve[] {
  const all = columnsOf(t);
  const value = all.find((c) => c.channel === channel && !c.spread);
  if (!value) return [];
  const spread = all.find((c) => c.channel === channel && c.spread);
  const own = all.find((c) => c.channel === `${channel}_model` && c.spread);
  const at = (name: string) => t.columns.indexOf(name);
  const group = at('group') >= 0 ? at('group') : at('slip_definition');
  const slips = ['slip', 'slip_symmetric', 'slip_rim'].map(at).filter((k) => k >= 0);
  const out = new Map<string, Curve>();
  const rows = t.rows.map((r) => ({ r, s: slips.map((k) => number(r[k])).find(Number.isFinite) ?? NaN })).filter(({ s }) => Number.isFinite(s));
  rows.sort((a, b) => a.s - b.s);
  for (const { r, s } of rows) {
    const key = group >= 0 ? String(r[group] ?? '') : '';
    if (!out.has(key)) out.set(key, { group: key, slip: [], value: [], error: [], model: [] });
    const c = out.get(key) as Curve;
    c.slip.push(s);
    c.value.push(number(r[value.index]));
    c.error.push(spread ? number(r[spread.index]) : NaN);
    c.model.push(own ? number(r[own.index]) : NaN);
  }
  return [...out.values()];
}

const titles: Record<string, string> = {
  drawbar_pull: 'Drawbar pull',
  driving_torque: 'Driving torque',
  sinkage: 'Sinkage',
  side_force: 'Side force',
  normal_force: 'Normal force',
  sinkage_profile: 'Sinkage from the hub height',
};

function sweepPlots(charts: Charts, rigs: Rig[]): HTMLElement {
  const grid = el('div', { class: 'grid' });
  const channels = new Map<string, string>();
  for (const r of rigs) for (const c of columnsOf(r.header.sweep)) if (titles[c.channel] && !c.spread) channels.set(c.channel, c.unit);
  const order = Object.keys(titles).filter((c) => channels.has(c));
  for (const channel of order) {
    const lines: Line[] = [];
    let k = 0;
    for (const rig of rigs)
      for (const c of curves(rig.header.sweep, channel)) {
        const label = [rigs.length > 1 ? rig.label : '', c.group].filter(Boolean).join(': ') || 'model';
        const colour = runColours[k++ % runColours.length];
        lines.push({ label, x: c.slip, y: c.value, error: c.error, colour });
        if (!c.model.some(Number.isFinite)) continue;
        for (const side of [-1, 1]) lines.push({ label: `${label}, ${side < 0 ? 'low' : 'high'} end of 90 %`, x: c.slip, y: c.value.map((v, i) => v + side * c.model[i]), colour, dash: [3, 4], width: 1 });
      }
    // The same measurement is beside each of the compared rigs: draw it once.
    const seen = new Set<string>();
    for (const rig of rigs)
      for (const c of rig.header.measured ? curves(rig.header.measured, channel) : []) {
        const key = JSON.stringify([c.slip, c.value]);
        if (seen.has(key)) continue;
        seen.add(key);
        lines.push({ label: 'measured', x: c.slip, y: c.value, error: c.error, colour: 'var(--ink)', points: true });
      }
    if (channel === 'side_force' && lines.every((l) => Array.from(l.y).every((v) => !(Math.abs(v) > 1e-3)))) continue;
    grid.append(charts.add({ title: titles[channel], unit: unitText(channels.get(channel) ?? ''), xLabel: 'slip [\u2013]', axis: 'other', height: 280, margin: true }, lines));
  }
  return grid;
}

function plainTable(t: Table): HTMLElement {
  const head = t.columns.map((c) => words(c));
  const rows = t.rows.map((r) => r.map((c) => (typeof c === 'number' ? el('span', { class: 'number' }, num(c)) : (c ?? ''))));
  return table(head, rows);
}

/** Time series and playback of one chosen case. */
function caseSection(rig: Rig): { root: HTMLElement; mount: () => void; restyle: () => void } | null {
  const all = rig.header.cases;
  if (all.length === 0) return null;
  const select = el('select', { 'aria-label': 'case' });
  all.forEach((c, k) => select.append(el('option', { value: String(k) }, c.title.replace(`${rig.header.title}: `, '') || c.folder)));
  const asked = /[#&]case=(\d+)/.exec(location.hash)?.[1];
  select.value = String(Math.min(all.length - 1, asked ? Number(asked) : all.length - 1));
  const host = el('div');
  let view: Playback | null = null;
  let charts = new Charts(null);
  const draw = () => {
    view?.dispose();
    view = null;
    const run = new Run(all[Number(select.value)], rig.block, rig.label, rig.colour);
    host.replaceChildren();
    if (run.time.length < 2) {
      host.append(el('p', { class: 'note' }, 'This case has no frames.'));
      return;
    }
    const clock = new Clock(run.time[0], run.time[run.time.length - 1]);
    charts = new Charts(clock);
    view = playback([run], clock);
    const grid = el('div', { class: 'grid' });
    for (const p of wheelPlots) {
      const lines = run.header.wheels.flatMap((w): Line[] => {
        const y = run.series(`${w}.${p.channel}`);
        return y && (p.channel !== 'side_force' || y.some((v) => Math.abs(v) > 1e-3)) ? [{ label: words(w), x: run.time, y: y.map((v) => v * p.factor), colour: rig.colour }] : [];
      });
      if (lines.length > 0) grid.append(charts.add({ title: p.title, unit: p.unit, xLabel: 'time [s]', axis: 'time' }, lines));
    }
    host.append(view.root, grid);
    charts.mount();
    view.mount();
    const t = /[#&]t=([\d.]+)/.exec(location.hash)?.[1];
    clock.seek(t ? Number(t) : clock.begin + 0.7 * (clock.end - clock.begin));
  };
  select.addEventListener('change', draw);
  const root = section('One case over time', '', el('div', { class: 'choice' }, el('label', { class: 'toggle' }, 'case', select)), host);
  return { root, mount: draw, restyle: () => charts.restyle() };
}

function sentence(rig: Rig): string {
  const t = rig.header.sweep;
  const pull = curves(t, 'drawbar_pull').flatMap((c) => c.slip.map((s, i) => [s, c.value[i]]));
  const sink = curves(t, 'sinkage').flatMap((c) => c.value);
  let text = `${t.rows.length} cases of one wheel`;
  if (rig.header.soil) text += ` on ${words(rig.header.soil)}`;
  text += `, soil model ${rig.header.terrain}`;
  if (pull.length > 0) {
    const s = pull.map((p) => p[0]);
    const f = pull.map((p) => p[1]);
    text += `: over slips from ${num(Math.min(...s), 2)} to ${num(Math.max(...s), 2)} the drawbar pull goes from ${num(Math.min(...f))} to ${num(Math.max(...f))} N`;
    if (sink.length > 0) text += ` and the sinkage from ${num(Math.min(...sink))} to ${num(Math.max(...sink))} mm`;
  }
  text += '.';
  const at = t.columns.indexOf('stationary');
  const moving = at < 0 ? 0 : t.rows.filter((r) => /^(0|false|no)$/.test(String(r[at]))).length;
  const far = t.columns.indexOf('outside');
  const most = far < 0 ? NaN : Math.max(...t.rows.map((r) => number(r[far])).filter(Number.isFinite));
  if (Number.isFinite(most)) text += ` Dashed: between them nine of ten runs of what the model was fitted to should lie; up to ${num(100 * most, 2)} % of the way lay outside of that.`;
  return text + (moving > 0 ? ` ${moving} case${moving > 1 ? 's are' : ' is'} not stationary over the averaging window.` : ' Bars are the standard deviation over the averaging window.');
}

export function rigPage(host: HTMLElement, rigs: Rig[]): Page {
  const charts = new Charts(null);
  const several = rigs.length > 1;
  const lead = el('div', { class: several ? 'lead several' : 'lead' });
  for (const rig of rigs) {
    const name = several ? el('h3', {}, el('i', { class: 'swatch', style: `background:${rig.colour}` }), rig.label) : null;
    lead.append(el('div', { class: 'card' }, name, el('p', { class: 'sentence' }, sentence(rig))));
  }
  host.append(lead);
  const note = warnings(rigs.flatMap((r) => r.header.warnings.map((w) => (several ? `${r.label}: ${w}` : w))));
  if (note) host.append(note);
  const measured = rigs.some((r) => r.header.measured);
  host.append(
    section('Steady values against slip', measured ? 'Lines: model, bars: standard deviation in time. Marks: measured, bars: reading error.' : 'Bars: standard deviation in time.', sweepPlots(charts, rigs)),
  );
  for (const rig of rigs) {
    if (rig.header.errors)
      host.append(section(several ? `Model against measurement: ${rig.label}` : 'Model against measurement', rig.header.errors.notes.join(' '), el('div', { class: 'card' }, plainTable(rig.header.errors))));
  }
  const cases = rigs.map(caseSection).filter((c) => c !== null);
  for (const c of cases) host.append(c.root);
  for (const rig of rigs) {
    const h = rig.header;
    host.append(
      section(
        several ? `About ${rig.label}` : 'About',
        [h.ground && `Ground: ${h.ground}.`, h.version && `Written by grouser ${h.version}.`].filter(Boolean).join(' '),
        assumptions([{ header: h }]),
        details('All steady values', plainTable(h.sweep)),
        h.scenario ? details('Rig file as it ran', el('pre', {}, h.scenario)) : null,
      ),
    );
  }
  return {
    charts: {
      restyle: () => {
        charts.restyle();
        cases.forEach((c) => c.restyle());
      },
    },
    mount: () => {
      charts.mount();
      cases.forEach((c) => c.mount());
    },
  };
}
