// The time that playback and plots share.

export class Clock {
  t: number;
  playing = false;
  speed = 1;
  private readonly listeners: (() => void)[] = [];
  private last = 0;

  constructor(
    readonly begin: number,
    readonly end: number,
  ) {
    this.t = begin;
  }

  listen(f: () => void): void {
    this.listeners.push(f);
  }

  seek(t: number): void {
    this.t = Math.min(this.end, Math.max(this.begin, t));
    this.changed();
  }

  toggle(): void {
    this.playing = !this.playing;
    if (this.playing) {
      if (this.t >= this.end) this.t = this.begin;
      this.last = performance.now();
      requestAnimationFrame(this.tick);
    }
    this.changed();
  }

  private readonly tick = (now: number): void => {
    if (!this.playing) return;
    // A hidden tab gets no frames: do not jump over the time it was away.
    const dt = Math.min(0.1, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    this.t += dt * this.speed;
    if (this.t >= this.end) {
      this.t = this.end;
      this.playing = false;
    }
    this.changed();
    if (this.playing) requestAnimationFrame(this.tick);
  };

  private changed(): void {
    for (const f of this.listeners) f();
  }
}
