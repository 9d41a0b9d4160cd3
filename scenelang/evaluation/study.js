"use strict";
{
  const study = JSON.parse(document.getElementById("study").textContent);
  const form = document.getElementById("form");
  const progress = document.getElementById("progress");
  const save = document.getElementById("save");
  const place = `scenelang-study-${study.study}`;

  const kept = () => {
    try {
      return JSON.parse(localStorage.getItem(place)) || {};
    } catch {
      return {}; // a browser that keeps nothing for files
    }
  };
  const fresh = () => Array.from(crypto.getRandomValues(new Uint8Array(8)), (b) => b.toString(16).padStart(2, "0")).join("");
  const before = kept();
  const participant = typeof before.participant === "string" ? before.participant : fresh();

  const choice = (number) => {
    const chosen = form.querySelector(`input[name="q${number}"]:checked`);
    return chosen ? study.questions[number].methods[Number(chosen.value)] : null;
  };
  const answers = () => study.questions.map((question, number) => ({
    prompt: question.prompt, methods: [...question.methods].sort(), choice: choice(number),
  }));

  const show = () => {
    const all = answers();
    const given = all.filter((answer) => answer.choice !== null).length;
    progress.textContent = `${given} of ${all.length} answered`;
    save.disabled = given < all.length;
    const choices = Object.fromEntries(all.map((answer) => [answer.prompt, answer.choice]));
    try {
      localStorage.setItem(place, JSON.stringify({ participant, choices }));
    } catch {
      // answers then last as long as the page is open
    }
  };

  study.questions.forEach((question, number) => {
    const earlier = question.methods.indexOf((before.choices || {})[question.prompt]);
    const input = form.querySelector(`input[name="q${number}"][value="${earlier}"]`);
    if (input) input.checked = true;
  });
  form.addEventListener("change", show);
  form.addEventListener("submit", (event) => event.preventDefault());
  save.addEventListener("click", () => {
    const told = { format: "scenelang-study-answers", version: 1, study: study.study, participant, answers: answers() };
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([JSON.stringify(told, null, 1)], { type: "application/json" }));
    link.download = `answers-${study.study}-${participant}.json`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  });
  show();
}
