// Lays out a report on paper: pictures are scaled page by page so that none leaves a gap at the foot of a page. Without
// scripts the style sheet bounds their heights alone.
const MM = 96 / 25.4;
const WIDTH = 182 * MM, HEIGHT = 259 * MM; // A4 within the margins of @page in report.css
const SLACK = 4 * MM; // lines may break otherwise on paper
const LEAST = 0.5; // of the width of a page, below which letters of a picture are too small
const WHOLE = "figure, .one .card, .several .card > .wide, .verdict"; // what no page break parts
const BLOCKS = `${WHOLE}, tr, h1, h2, h3, h4, p, li, pre, summary, caption`;
let undo = [];

/** The style sheets as for paper, until they are called back. */
function asPaper() {
  const rules = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules]).filter((rule) => rule instanceof CSSMediaRule);
  const media = rules.map((rule) => rule.media.mediaText);
  rules.forEach((rule) => (rule.media.mediaText = rule.media.mediaText === "print" ? "all" : "not all"));
  return () => rules.forEach((rule, i) => (rule.media.mediaText = media[i]));
}

/** What a page break must not part: its height without that of its picture, the full height of the picture, the height
 * of the head that a table repeats above it, and whether a break may come before it. */
function measured() {
  const own = [...document.body.querySelectorAll(BLOCKS)].filter((el) => el.getClientRects().length && !el.parentElement.closest(`${WHOLE}, thead, pre`));
  const blocks = [];
  for (const el of own.filter((el) => !el.closest("thead") || el.matches(":first-child"))) {
    const img = el.matches("figure") ? el.querySelector("img") : null, top = el.getBoundingClientRect().top;
    const last = blocks.at(-1);
    if (last && top < last.top + 1 && !img) continue; // beside the last one
    const head = el.closest("tbody") && el.previousElementSibling ? el.closest("table").tHead?.offsetHeight ?? 0 : 0;
    const tied = last && (last.el.matches("h1, h2, h3, h4, caption, summary, thead tr") || last.el.matches("h2 + .note") || el.matches(".assessment tbody tr:not(.first)"));
    blocks.push({ el, img, top, head, tied });
  }
  const end = document.getElementById("main").getBoundingClientRect().bottom;
  blocks.forEach((block, i) => {
    const full = block.img ? block.img.getBoundingClientRect().height : 0;
    Object.assign(block, { full, fixed: (blocks[i + 1]?.top ?? end) - block.top - full });
  });
  return blocks;
}

/** First blocks of the pages, with the scale of the pictures of each: least squares of empty paper and of small pictures. */
function pagesOf(blocks) {
  const n = blocks.length, best = [{ cost: 0 }];
  for (let to = 1; to <= n; to++) best.push({ cost: Infinity });
  for (let from = 0; from < n; from++) {
    if (blocks[from].tied || best[from].cost === Infinity) continue;
    let fixed = blocks[from].head, full = 0;
    for (let to = from + 1; to <= n; to++) {
      fixed += blocks[to - 1].fixed;
      full += blocks[to - 1].full;
      const room = HEIGHT - SLACK - fixed, scale = full ? Math.min(1, room / full) : 1;
      if (to > from + 1 && (room < 0 || scale < LEAST)) break;
      const empty = Math.max(0, (room - scale * full) / HEIGHT);
      const foot = to < n ? empty ** 2 : 4 * Math.max(0, empty - 0.25) ** 2;
      const cost = best[from].cost + 0.02 + foot + (full ? 0.4 * (1 - scale) ** 2 : 0);
      if (cost < best[to].cost) best[to] = { cost, from, scale: Math.max(scale, LEAST) };
    }
  }
  const pages = [];
  for (let to = n; to > 0; to = best[to].from) pages.unshift({ ...best[to], to });
  return pages;
}

addEventListener("beforeprint", () => {
  const html = document.documentElement, asScreen = asPaper();
  html.classList.add("paged");
  document.body.style.width = `${WIDTH}px`;
  const blocks = measured(), pages = pagesOf(blocks);
  for (const { from, to, scale } of pages) {
    if (from && !blocks[from].el.matches("tr, li")) blocks[from].el.classList.add("page-top");
    for (const { img, full } of blocks.slice(from, to)) if (img) img.style.height = `${Math.floor(scale * full)}px`;
  }
  document.body.style.width = "";
  asScreen();
  undo.push(() => {
    html.classList.remove("paged");
    for (const { el, img } of blocks) {
      el.classList.remove("page-top");
      if (img) img.style.height = "";
    }
  });
});
addEventListener("afterprint", () => {
  for (const back of undo) back();
  undo = [];
});
