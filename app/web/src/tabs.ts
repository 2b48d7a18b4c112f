// One tab per section; a single section stands alone. #tab=2 opens the second.
import type { Page } from './run_page';
import { el } from './text';

export interface TabSection {
  label: string;
  build(host: HTMLElement): Promise<Page>;
}

export async function tabs(page: HTMLElement, sections: TabSection[]): Promise<void> {
  const hosts = sections.map(() => el('div', { role: 'tabpanel' }));
  const built = new Set<number>();
  const buttons = sections.map((s) => el('button', { role: 'tab' }, s.label));
  // Hidden panels have no size, so a panel is built and mounted when it is shown for the first time.
  const show = async (k: number) => {
    hosts.forEach((h, i) => (h.hidden = i !== k));
    buttons.forEach((b, i) => b.setAttribute('aria-selected', String(i === k)));
    if (built.has(k)) return;
    built.add(k);
    (await sections[k].build(hosts[k])).mount();
  };
  buttons.forEach((b, k) => b.addEventListener('click', () => void show(k)));
  if (sections.length > 1) page.append(el('nav', { class: 'tabs', role: 'tablist' }, ...buttons));
  page.append(...hosts);
  const asked = Number(/[#&]tab=(\d+)/.exec(location.hash)?.[1] ?? 1) - 1;
  await show(asked >= 0 && asked < sections.length ? asked : 0);
}
