#pragma once

namespace maquette::report {

/// The page's style sheet: light and dark by the reader's system, readable when printed.
inline constexpr const char* kPageStyle = R"css(
:root { color-scheme: light dark; --ink: #1d2127; --soft: #5c6570; --line: #d9dde2; --paper: #ffffff; --panel: #f5f6f8;
  --best: #d9f0e3; --warn: #9a5b00; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7eb; --soft: #9aa4b0; --line: #363c44; --paper: #16191d; --panel: #1f2329; --best: #1d4331;
    --warn: #f0b35a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 32px 28px 64px; background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 28px; line-height: 1.2; margin: 0 0 6px; }
h2 { font-size: 20px; margin: 44px 0 10px; padding-top: 14px; border-top: 1px solid var(--line); }
h3 { font-size: 16px; margin: 26px 0 8px; }
p { margin: 8px 0; max-width: 78ch; }
.lead, .note, figcaption, .small { color: var(--soft); }
.small, .note { font-size: 13px; }
.warn { color: var(--warn); }
code { font: 13px ui-monospace, "DejaVu Sans Mono", monospace; background: var(--panel); padding: 1px 4px;
  border-radius: 3px; overflow-wrap: anywhere; }
.summary { background: var(--panel); border: 1px solid var(--line); border-radius: 8px; padding: 14px 20px; margin: 20px 0; }
.summary ul { margin: 6px 0; padding-left: 20px; }
.summary li { margin: 4px 0; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(460px, 1fr)); gap: 14px 22px; }
figure { margin: 0; break-inside: avoid; }
.charts figcaption { font-weight: 600; color: var(--ink); margin: 8px 0 0; }
.charts img { width: 100%; height: auto; display: block; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(205px, 1fr)); gap: 16px; }
.gallery img { width: 100%; height: auto; display: block; border-radius: 3px; background: var(--panel); }
.gallery img + img { margin-top: 4px; }
.gallery figcaption { font-size: 13px; margin-top: 4px; line-height: 1.35; }
.gallery figcaption b { color: var(--ink); }
.scale { display: inline-block; width: 180px; height: 10px; vertical-align: middle; border-radius: 2px; margin: 0 6px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; margin: 8px 0; }
th, td { text-align: left; padding: 4px 14px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 600; }
td.n, th.n { text-align: right; white-space: nowrap; }
td.best { background: var(--best); }
.dot { display: inline-block; width: 10px; height: 10px; border-radius: 50%; margin-right: 7px; }
summary { cursor: pointer; color: var(--soft); margin: 10px 0; }
@media print { body { max-width: none; padding: 0; } details { display: none; } }
@media (max-width: 560px) { .charts { grid-template-columns: 1fr; } body { padding: 18px 14px; } }
)css";

}  // namespace maquette::report
