// Making elements. Text goes in as text only, never as markup: words and messages come from programs.

// An element with properties, `data-`/`aria-` attributes and children (elements or text).
export function el(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name.includes("-") || name === "role" || name === "for") element.setAttribute(name, String(value));
    else element[name] = value;
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

// Replaces all children.
export function fill(element, ...children) {
  element.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
}

export function byId(id) {
  return document.getElementById(id);
}

const NUMBER = new Intl.NumberFormat("en-US");
const SHORT = new Intl.NumberFormat("en-US", { notation: "compact", maximumSignificantDigits: 3 });

// A count as text; beyond what is exact, to three digits.
export function counted(number) {
  return number <= Number.MAX_SAFE_INTEGER ? NUMBER.format(number) : number.toExponential(2);
}

// A count in little room: 12,345 but 100B.
export function brief(number) {
  return number < 1e7 ? NUMBER.format(number) : number < 1e15 ? SHORT.format(number) : number.toExponential(1);
}

// Calls `action` once nothing has asked for it during `milliseconds`.
export function debounced(action, milliseconds) {
  let timer = 0;
  return (...values) => {
    clearTimeout(timer);
    timer = setTimeout(() => action(...values), milliseconds);
  };
}
