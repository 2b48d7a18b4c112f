// report.html: read the header, unpack the blocks, build the page.
import 'uplot/dist/uPlot.min.css';
import './style.css';
import { runColours } from './colours';
import { Block, Run, type Header, type RunHeader } from './data';
import { figurePage } from './figure_page';
import { rigPage } from './rig_page';
import { runPage, type Page } from './run_page';
import { tabs } from './tabs';
import { el } from './text';

/** Short names that tell the runs apart: the model when it differs, else the folder. */
function labels(items: { terrain: string; folder: string; soil: string }[]): string[] {
  for (const of of [(r: (typeof items)[0]) => r.terrain, (r: (typeof items)[0]) => r.soil, (r: (typeof items)[0]) => r.folder]) {
    const names = items.map(of);
    if (new Set(names).size === items.length && names.every(Boolean)) return names;
  }
  return items.map((r, k) => `${r.folder} (${k + 1})`);
}

/** Runs grouped by their ground, in the order of the file. */
function byGround(runs: RunHeader[]): RunHeader[][] {
  const groups = new Map<string, RunHeader[]>();
  for (const r of runs) groups.set(r.ground, [...(groups.get(r.ground) ?? []), r]);
  return [...groups.values()];
}

function schemeButton(pages: Page[]): HTMLElement {
  const root = document.documentElement;
  const asked = /[#&]scheme=(dark|light)/.exec(location.hash)?.[1];
  const prefers = window.matchMedia('(prefers-color-scheme: dark)');
  const set = (scheme: string) => {
    root.dataset.scheme = scheme;
    button.textContent = scheme === 'dark' ? 'light page' : 'dark page';
    pages.forEach((p) => p.charts.restyle());
  };
  const button = el('button', { class: 'scheme' });
  button.addEventListener('click', () => set(root.dataset.scheme === 'dark' ? 'light' : 'dark'));
  prefers.addEventListener('change', (e) => set(e.matches ? 'dark' : 'light'));
  // Paper is light.
  let before = '';
  window.addEventListener('beforeprint', () => ((before = root.dataset.scheme ?? 'light'), set('light')));
  window.addEventListener('afterprint', () => set(before));
  set(asked ?? (prefers.matches ? 'dark' : 'light'));
  return button;
}

async function start(): Promise<void> {
  const page = document.getElementById('page');
  const text = document.getElementById('header')?.textContent;
  if (!page || !text) throw new Error('the report has no data');
  const header = JSON.parse(text) as Header;
  const block = async (k: number) => {
    const script = document.getElementById(`block-${k}`);
    const unpacked = await Block.unpack(script?.textContent ?? '');
    script?.remove();
    return unpacked;
  };

  const pages: Page[] = [];
  page.replaceChildren();
  const grounds = byGround(header.runs);
  const count = header.runs.length + header.rigs.length;
  const kind = count <= 1 ? null : `Comparison of ${count} results` + (grounds.length > 1 ? ` over ${grounds.length} grounds` : '');
  const top = el('header', {}, el('div', {}, el('h1', {}, header.title || 'grouser'), kind ? el('p', { class: 'kind' }, kind) : null));
  top.append(schemeButton(pages));
  page.append(top);

  // Runs are comparable over the same ground: one tab per ground, built when it is first looked at.
  if (grounds.length > 0) {
    const sections = grounds.map((runs) => ({
      label: runs[0].title,
      build: async (host: HTMLElement) => {
        const names = labels(runs);
        const loaded: Run[] = [];
        for (const [k, h] of runs.entries()) loaded.push(new Run(h, await block(h.block ?? 0), names[k], runColours[k % runColours.length]));
        const built = runPage(host, loaded);
        pages.push(built);
        return built;
      },
    }));
    await tabs(page, sections);
  }
  if (header.rigs.length > 0) {
    const names = labels(header.rigs);
    const rigs = [];
    for (const [k, h] of header.rigs.entries())
      rigs.push({ header: h, block: await block(h.block), label: names[k], colour: runColours[k % runColours.length] });
    const built = rigPage(page, rigs);
    pages.push(built);
    built.mount();
  }
  if (header.figures) {
    const built = figurePage(page, header.figures);
    pages.push(built);
    built.mount();
  }
  page.append(el('footer', {}, 'Written by grouser. This file needs no network; all data are inside.'));
  document.documentElement.dataset.ready = '1';
}

start().catch((e: unknown) => {
  console.error(e);
  const reason = e instanceof Error ? e.message : String(e);
  document.getElementById('page')?.append(el('p', { class: 'warnings' }, `The report could not be shown: ${reason}`));
});
