// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Style and script of every page. Nothing is fetched from anywhere: the policy forbids it.
namespace ra2d {

inline constexpr char page_policy[] =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; media-src data:; "
    "base-uri 'none'; form-action 'none'";

inline constexpr char page_style[] = R"css(
:root { color-scheme: light dark; --paper: #fff; --ink: #1b1f24; --soft: #57606a; --rule: #d0d7de;
  --grid: #e6eaee; --fill: #2f6db5; --bar: #7fa8d6; --note: #fff4d6;
  --s0: #2b45c8; --s1: #bb560f; --s2: #6b1170; --s3: #056545; --s4: #3f97e0; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181d; --ink: #e6e9ec; --soft: #a3adb8;
  --rule: #3b434d; --grid: #2a3038; --fill: #8bbcf0; --bar: #3f6b9c; --note: #3d3214;
  --s0: #8bbcf0; --s1: #f0a15a; --s2: #d59be0; --s3: #6fd0a8; --s4: #d8d060; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1rem; max-width: 72rem; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: .5rem 0; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .5rem; border-top: 2px solid var(--rule); padding-top: 1rem; }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .4rem; }
p.lead, figcaption, .soft { color: var(--soft); }
a { color: var(--fill); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .3rem .8rem .3rem 0;
  border-bottom: 1px solid var(--grid); }
th { font-weight: 600; }
.facts th { width: 11rem; font-weight: normal; color: var(--soft); }
.means td, .means th { white-space: nowrap; overflow-wrap: normal; }
.means td:first-child { white-space: normal; min-width: 8rem; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr));
  gap: .5rem 2rem; }
figure { margin: .5rem 0; break-inside: avoid; min-width: 0; }
figcaption { font-size: .9rem; }
figcaption b { color: var(--ink); }
sup, sub { line-height: 0; }
svg { display: block; width: 100%; height: auto; font: 12.5px system-ui, sans-serif; }
svg text { fill: var(--ink); }
svg path { fill: none; stroke: var(--ink); }
svg .grid { stroke: var(--grid); }
svg .line { stroke: var(--fill); stroke-width: 1.4; stroke-linejoin: round; }
svg .bar { fill: var(--bar); }
svg .dot { fill: var(--fill); }
svg .whisker { stroke-width: 1.3; }
svg .series0 { stroke: var(--s0); } svg circle.series0 { fill: var(--s0); } figcaption b.series0 { color: var(--s0); }
svg .series1 { stroke: var(--s1); } svg circle.series1 { fill: var(--s1); } figcaption b.series1 { color: var(--s1); }
svg .series2 { stroke: var(--s2); } svg circle.series2 { fill: var(--s2); } figcaption b.series2 { color: var(--s2); }
svg .series3 { stroke: var(--s3); } svg circle.series3 { fill: var(--s3); } figcaption b.series3 { color: var(--s3); }
svg .series4 { stroke: var(--s4); } svg circle.series4 { fill: var(--s4); } figcaption b.series4 { color: var(--s4); }
svg .mark { stroke-width: 1.2; }
svg .dashed { stroke-dasharray: 5 4; }
svg .name { paint-order: stroke; stroke: var(--paper); stroke-width: 4px; }
audio { width: 100%; display: block; margin-top: .3rem; }
pre { background: var(--grid); padding: .8rem; overflow-x: auto; font-size: .85rem;
  overflow-wrap: normal; }
button { font: inherit; padding: .2rem .8rem; }
.note { background: var(--note); padding: .6rem .9rem; border-left: 4px solid var(--ink); }
.note p { margin: .2rem 0; }
footer { margin-top: 2.5rem; border-top: 1px solid var(--rule); font-size: .9rem; color: var(--soft); }
@media (max-width: 30rem) { .facts th { width: 7.5rem; } svg { font-size: 14px; }
  .means { font-size: .8rem; } .means td, .means th { white-space: normal; padding-right: .4rem; }
  .means td:first-child { min-width: 3.5rem; } }
@media print {
  :root { --paper: #fff; --ink: #000; --soft: #333; --rule: #999; --grid: #ddd; --fill: #1d4f8c;
    --bar: #9dbce0; --note: #fff; }
  body { max-width: none; font-size: 10pt; padding: 0; }
  .sound, button { display: none; }
  pre { white-space: pre-wrap; }
  .columns { grid-template-columns: 1fr 1fr; }
  h2, h3 { break-after: avoid; }
}
)css";

/// Copies a scene where the clipboard can be had; selects it where not.
inline constexpr char page_script[] = R"js(
for (const button of document.querySelectorAll("button[data-copies]")) {
  button.hidden = false;
  button.addEventListener("click", async () => {
    const text = document.getElementById(button.dataset.copies);
    const range = document.createRange();
    range.selectNodeContents(text);
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    let copied = false;
    try { await navigator.clipboard.writeText(text.textContent); copied = true; }
    catch { copied = document.execCommand("copy"); }
    button.textContent = copied ? "Copied" : "Selected: copy it now";
  });
}
)js";

}  // namespace ra2d
