// report.html: read the header, unpack the blocks, build the page.
import 'uplot/dist/uPlot.min.css';
import './style.css';
import { runColours } from './colours';
import { Block, Run, type Header } from './data';
import { rigPage } from './rig_page';
import { runPage, type Page } from './run_page';
import { el } from './text';

/** Short names that tell the runs apart: the model when it differs, else the folder. */
function labels(items: { terrain: string; folder: string; soil: string }[]): string[] {
  for (const of of [(r: (typeof items)[0]) => r.terrain, (r: (typeof items)[0]) => r.soil, (r: (typeof items)[0]) => r.folder]) {
    const names = items.map(of);
    if (new Set(names).size === items.length && names.every(Boolean)) return names;
  }
  return items.map((r, k) => `${r.folder} (${k + 1})`);
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
  const several = header.runs.length + header.rigs.length > 1;
  const top = el('header', {}, el('div', {}, el('h1', {}, header.title || 'grouser'), several ? el('p', { class: 'kind' }, `Comparison of ${header.runs.length + header.rigs.length} results`) : null));
  top.append(schemeButton(pages));
  page.append(top);

  if (header.runs.length > 0) {
    const names = labels(header.runs);
    const runs: Run[] = [];
    for (const [k, h] of header.runs.entries())
      runs.push(new Run(h, await block(h.block ?? 0), names[k], runColours[k % runColours.length]));
    pages.push(runPage(page, runs));
  }
  if (header.rigs.length > 0) {
    const names = labels(header.rigs);
    const rigs = [];
    for (const [k, h] of header.rigs.entries())
      rigs.push({ header: h, block: await block(h.block), label: names[k], colour: runColours[k % runColours.length] });
    pages.push(rigPage(page, rigs));
  }
  page.append(el('footer', {}, 'Written by grouser. This file needs no network; all data are inside.'));
  pages.forEach((p) => p.mount());
  document.documentElement.dataset.ready = '1';
}

start().catch((e: unknown) => {
  console.error(e);
  const reason = e instanceof Error ? e.message : String(e);
  document.getElementById('page')?.append(el('p', { class: 'warnings' }, `The report could not be shown: ${reason}`));
});
