// The timeline of a 4D scene: play, pause, step.
import { counted } from "./dom.js";

export class Timeline {
  constructor({ bar, play, slider, label, rate }, show, paused) {
    Object.assign(this, { bar, play, slider, label, rate, show, paused, frames: 1, frame: 0, playing: false });
    play.addEventListener("click", () => this.toggle());
    slider.addEventListener("input", () => this.go(Number(slider.value)));
  }

  take(frames) {
    this.frames = frames;
    this.bar.hidden = frames < 2;
    if (frames < 2) this.pause();
    this.slider.max = String(frames - 1);
    this.frame = Math.min(this.frame, frames - 1);
    this.write();
  }

  go(frame) {
    this.frame = ((frame % this.frames) + this.frames) % this.frames;
    this.write();
    this.show(this.frame);
  }

  write() {
    this.slider.value = String(this.frame);
    this.slider.setAttribute("aria-valuetext", `frame ${this.frame}`);
    this.label.textContent = `${counted(this.frame)} / ${counted(this.frames - 1)}`;
  }

  toggle() {
    if (this.playing) this.pause();
    else if (this.frames > 1) this.start();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.play.textContent = "Play";
    this.paused();
  }

  start() {
    this.playing = true;
    this.play.textContent = "Pause";
    let due = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const interval = 1000 / Number(this.rate.value);
      if (now >= due) {
        due = Math.max(due + interval, now - interval);
        this.go(this.frame + 1);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}
