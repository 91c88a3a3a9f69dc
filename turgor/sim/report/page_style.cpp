// Style and script of the report's page, for screens, dark screens and A4 paper.
#include "turgor/sim/report/page.hpp"

namespace turgor::page {

namespace {

constexpr const char* kBeforeTitle = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
)";

constexpr const char* kStyle = R"(<style>
:root { color-scheme: light dark; --ground: #fbfaf8; --card: #ffffff; --ink: #22262b; --soft: #6b737d; --line: #e3e1dc; --accent: #b4502f; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #14171a; --card: #1c2024; --ink: #e8e6e1; --soft: #98a1ab; --line: #2f353b; --accent: #f0936f; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 1.9rem; margin: 0; letter-spacing: -0.01em; } h2 { font-size: 1.2rem; margin: 2.6rem 0 0.8rem; }
.verdict { font-size: 1.25rem; line-height: 1.45; margin: 0.9rem 0 0.4rem; max-width: 46rem; }
.soft { color: var(--soft); } .warning { border-left: 4px solid var(--accent); padding: 0.4rem 0.9rem; background: var(--card); }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 0.8rem; margin: 1.6rem 0; }
.figures div, figure, .plot { background: var(--card); border: 1px solid var(--line); border-radius: 10px; }
.figures div { padding: 0.8rem 1rem; } .figures b { display: block; font-size: 1.5rem; font-variant-numeric: tabular-nums; }
.figures span { color: var(--soft); font-size: 0.85rem; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 1rem; } .grid > * { min-width: 0; }
figure { margin: 0; overflow: hidden; } figure.large { grid-column: 1 / -1; } figure img, figure video { display: block; width: 100%; height: auto; }
figcaption { padding: 0.55rem 0.9rem; font-size: 0.88rem; color: var(--soft); }
.plot-read { font-weight: 600; paint-order: stroke; stroke: var(--card); stroke-width: 4px; }
.plot { padding: 0.6rem; overflow-x: auto; } .plot svg { width: 100%; min-width: 460px; height: auto; display: block; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 0.93rem; }
th, td { text-align: right; padding: 0.4rem 0.7rem; border-bottom: 1px solid var(--line); } th:first-child, td:first-child { text-align: left; }
th { font-weight: 600; color: var(--soft); }
.beside { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(440px, 100%), 1fr)); gap: 0 2rem; align-items: start; }
.beside > * { min-width: 0; } .beside td, .beside th { overflow-wrap: anywhere; } tr.default { color: var(--soft); }
table.parameters td, table.parameters th { text-align: left; padding: 0.25rem 0.5rem; } table.parameters { font-size: 0.85rem; }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 1rem; overflow-x: auto; font-size: 0.85rem; }
code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; }
@page { size: A4; margin: 14mm; }
@media print {
  :root { color-scheme: light; --ground: #ffffff; --card: #ffffff; --ink: #000000; --soft: #444444; --line: #bbbbbb; --accent: #b4502f; }
  body { font-size: 10pt; } main { max-width: none; padding: 0; } h1 { font-size: 16pt; } h2 { font-size: 12pt; margin: 1.2rem 0 0.4rem; }
  h2, th { break-after: avoid; } figure, .plot, .figures div, tr, .verdict, .warning { break-inside: avoid; }
  .figures { grid-template-columns: repeat(4, 1fr); } .figures b { font-size: 13pt; } .grid { grid-template-columns: 1fr 1fr; }
  .beside { grid-template-columns: 1fr; } .scroll, .plot { overflow: visible; } .plot svg { min-width: 0; }
  pre { white-space: pre-wrap; font-size: 8pt; } #motion, .motion-title, video, .files { display: none; }
}
</style></head><body><main>
)";

/// Script that shows the values of the curve nearest to the mouse.
constexpr const char* kReadPlots = R"js(<script>
for (const plot of document.querySelectorAll('.turgor-plot')) {
  const area = plot.querySelector('.plot-area'), curves = [...plot.querySelectorAll('.plot-curve')];
  if (!area || curves.length === 0) continue;
  const number = (name) => Number(area.getAttribute(name)), pair = (name) => area.getAttribute(name).split(' ').map(Number);
  const [x0, x1] = pair('data-x'), [y0, y1] = pair('data-y'), powers = area.getAttribute('data-powers') === 'yes';
  const points = curves.flatMap((curve) => curve.getAttribute('d').slice(1).split('L').map((p) => [...p.split(' ').map(Number), curve]));
  const make = (name) => plot.appendChild(document.createElementNS('http://www.w3.org/2000/svg', name)), dot = make('circle'), text = make('text');
  dot.setAttribute('r', 4), dot.style.display = text.style.display = 'none', text.setAttribute('class', 'plot-read');
  plot.addEventListener('pointermove', (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse());
    const far = (p) => 4 * Math.abs(p[0] - at.x) + Math.abs(p[1] - at.y), near = points.reduce((a, b) => (far(b) < far(a) ? b : a));
    const x = x0 + (near[0] - number('x')) / number('width') * (x1 - x0);
    const level = y1 - (near[1] - number('y')) / number('height') * (y1 - y0), y = powers ? 10 ** level : level;
    const right = near[0] > number('x') + 0.6 * number('width');
    dot.setAttribute('cx', near[0]), dot.setAttribute('cy', near[1]), dot.setAttribute('fill', near[2].getAttribute('stroke'));
    text.setAttribute('x', near[0] + (right ? -8 : 8)), text.setAttribute('y', Math.max(number('y') + 14, near[1] - 8));
    text.setAttribute('text-anchor', right ? 'end' : 'start');
    text.textContent = Number(x.toPrecision(4)) + ', ' + Number(y.toPrecision(4)), dot.style.display = text.style.display = '';
  });
  plot.addEventListener('pointerleave', () => { dot.style.display = text.style.display = 'none'; });
}
</script>
)js";

}  // namespace

std::string page_head(const std::string& title) {
  return kBeforeTitle + ("<title>Turgor: " + title) + "</title>\n" + kStyle;
}

std::string page_end() { return std::string(kReadPlots) + "</main></body></html>\n"; }

}  // namespace turgor::page
