// The controls of the viewer. Names of files and of their
// content are only ever set as text, never as HTML.

import { facts } from "./model.js";
import { save } from "./picture.js";
import { POSES } from "./poses.js";

const find = (id) => document.getElementById(id);

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

export class Panel {
  constructor({ name, viewer, wardrobe }) {
    Object.assign(this, { name, viewer, wardrobe });
    document.title = name;
    find("name").textContent = name;
    this.#view();
    this.#poses();
    this.#expressions();
    this.#textures();
    this.#picture();
    this.#motion();
    this.#keys();
    for (const [what, value] of facts(viewer.model)) {
      find("about").append(element("dt", { textContent: what }), element("dd", { textContent: value }));
    }
    find("open-panel").onclick = () => this.toggle(true);
    find("close-panel").onclick = () => this.toggle(false);
    this.toggle(matchMedia("(min-width: 760px)").matches);
  }

  /// Shows a message for a while, or until the next one.
  say(text) {
    const message = find("message");
    message.classList.add("brief");
    message.textContent = text;
    clearTimeout(this.silence);
    if (text) this.silence = setTimeout(() => this.say(""), 6000);
  }

  toggle(isOpen = find("panel").hidden) {
    const hadFocus = find("panel").contains(document.activeElement) || document.activeElement === find("open-panel");
    find("panel").hidden = !isOpen;
    find("open-panel").setAttribute("aria-expanded", String(isOpen));
    document.body.classList.toggle("with-panel", isOpen);
    if (hadFocus) find(isOpen ? "close-panel" : "open-panel").focus();
  }

  #view() {
    const { viewer } = this;
    for (const button of find("frames").children) button.onclick = () => viewer.frame(button.dataset.frame);
    find("light").onchange = ({ target }) => viewer.setUnlit(target.value === "unlit");
    find("background").onchange = ({ target }) => viewer.setBackground(target.value);
    find("skeleton").onchange = ({ target }) => viewer.setSkeleton(target.checked);
    find("wireframe").onchange = ({ target }) => viewer.setWireframe(target.checked);
    find("ground").onchange = ({ target }) => viewer.setGround(target.checked);
  }

  #poses() {
    const { viewer } = this;
    if (!viewer.rig.canPose) return;
    find("pose-section").hidden = false;
    for (const [name, { title }] of Object.entries(POSES)) {
      const button = element("button", { type: "button", textContent: title, onclick: () => viewer.setPose(name) });
      button.dataset.pose = name;
      find("poses").append(button);
    }
    const show = () => {
      for (const button of find("poses").children) button.setAttribute("aria-pressed", String(button.dataset.pose === viewer.pose));
    };
    viewer.addEventListener("change", show);
    show();
  }

  #expressions() {
    const { viewer } = this;
    const names = [...viewer.expressions.weights.keys()];
    if (!names.length) return;
    find("expression-section").hidden = false;
    const shows = names.map((name) => {
      const slider = element("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0 });
      const value = element("output");
      slider.oninput = () => viewer.setExpression(name, slider.valueAsNumber);
      const label = element("label", { className: "slider", title: name }, element("span", { textContent: name }), slider, value);
      find("expressions").append(label);
      return () => {
        const weight = viewer.expressions.weights.get(name);
        if (slider.valueAsNumber !== weight) slider.value = weight;
        value.textContent = weight.toFixed(2);
      };
    });
    const show = () => shows.forEach((each) => each());
    find("neutral").onclick = () => names.forEach((name) => viewer.setExpression(name, 0));
    viewer.addEventListener("change", show);
    show();
  }

  #textures() {
    const { wardrobe } = this;
    const wear = (work) => work.then(() => this.say("")).catch((error) => this.say(error.message));
    const add = (file) => {
      if (!wardrobe.canChange) this.say("This figure has no texture that another could take the place of.");
      else if (file) wear(wardrobe.add(file));
    };
    const show = () => {
      find("part-row").hidden = wardrobe.parts.length < 2;
      find("part").replaceChildren(...wardrobe.parts.map(({ name }, index) => new Option(name, index)));
      find("part").value = wardrobe.chosenPart;
      const hadFocus = find("textures").contains(document.activeElement);
      const choices = wardrobe.textures.map(({ name }, index) => {
        const radio = element("input", { type: "radio", name: "texture", checked: index === wardrobe.worn, disabled: !wardrobe.canChange });
        radio.onchange = () => wear(wardrobe.wear(index));
        return element("label", { className: "switch" }, radio, element("span", { textContent: name }));
      });
      find("textures").replaceChildren(...choices);
      if (hadFocus) find("textures").querySelector(":checked")?.focus();
    };
    find("part").onchange = ({ target }) => wardrobe.choosePart(Number(target.value));
    find("open-texture").onchange = ({ target }) => {
      add(target.files[0]);
      target.value = "";
    };
    wardrobe.addEventListener("change", show);
    show();

    addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    const stop = () => document.body.classList.remove("dropping");
    addEventListener("dragleave", (event) => event.relatedTarget || stop());
    addEventListener("drop", (event) => {
      event.preventDefault();
      stop();
      add(event.dataTransfer.files[0]);
    });
  }

  #picture() {
    const { viewer } = this;
    find("save-picture").onclick = () => {
      const choice = Number(find("picture-size").value);
      const { clientWidth, clientHeight } = viewer.stage.place;
      const scale = choice * window.devicePixelRatio;
      const [width, height] = choice > 2 ? [choice, choice] : [clientWidth, clientHeight].map((side) => Math.round(side * scale));
      const canvas = viewer.picture(width, height, { transparent: find("transparent").checked });
      save(canvas, `${this.name.replace(/\.[^.]*$/, "").replace(/[^\p{L}\p{N}._-]+/gu, "_") || "avatar"}.png`);
    };
  }

  #motion() {
    const { viewer } = this;
    const { motion } = viewer;
    if (!motion.clips.length) return;
    find("motion").hidden = false;
    viewer.covered = find("motion").offsetHeight + 12;
    find("motion").onsubmit = (event) => event.preventDefault();
    motion.clips.forEach(({ name }, index) => find("clip").append(new Option(name || `motion ${index + 1}`, index)));
    find("clip").append(new Option("none: a pose", ""));
    find("clip").onchange = ({ target }) => {
      if (target.value === "") viewer.setPose("rest");
      else if (viewer.setClip(Number(target.value))) viewer.play(true);
    };
    find("play").onclick = () => this.#playOrPause();
    find("time").oninput = ({ target }) => viewer.setTime(target.valueAsNumber * motion.duration);
    find("speed").onchange = ({ target }) => {
      motion.speed = Number(target.value);
    };
    const showTime = () => {
      find("time").value = motion.duration ? motion.time / motion.duration : 0;
      find("clock").textContent = `${motion.time.toFixed(1)} / ${motion.duration.toFixed(1)} s`;
    };
    const show = () => {
      document.body.classList.toggle("playing", motion.playing);
      const clip = motion.action?.getClip();
      find("clip").value = clip ? motion.clips.indexOf(clip) : "";
      find("time").disabled = !clip;
      showTime();
    };
    viewer.addEventListener("change", show);
    viewer.addEventListener("time", showTime);
    show();
  }

  #playOrPause() {
    const { viewer } = this;
    if (!viewer.motion.action) viewer.setClip(0);
    viewer.play(!viewer.motion.playing);
  }

  // A key for each frequent action, unless the focused control uses that key itself.
  #keys() {
    const click = (id) => () => find(id).click();
    const keys = {
      " ": () => this.viewer.motion.clips.length && this.#playOrPause(),
      b: () => this.viewer.frame("body"),
      h: () => this.viewer.frame("head"),
      p: () => this.toggle(),
      s: click("skeleton"),
      w: click("wireframe"),
      g: click("ground"),
      c: click("save-picture"),
    };
    addEventListener("keydown", (event) => {
      const isTyping = event.target.matches?.("select, input:not([type=checkbox], [type=radio], [type=range])");
      const isPressing = event.key === " " && event.target.matches?.("button, input");
      if (event.ctrlKey || event.metaKey || event.altKey || isTyping || isPressing) return;
      const action = keys[event.key.toLowerCase()];
      if (!action) return;
      event.preventDefault();
      action();
    });
    // For use without a mouse: arrows orbit the camera, plus and minus move it closer and away.
    this.viewer.stage.canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const turn = turns[event.key];
      if (turn) this.viewer.stage.orbit(...turn.map((steps) => steps * 0.12));
      else if (event.key === "+" || event.key === "=") this.viewer.stage.approach(0.85);
      else if (event.key === "-") this.viewer.stage.approach(1 / 0.85);
      else return;
      event.preventDefault();
    });
  }
}
