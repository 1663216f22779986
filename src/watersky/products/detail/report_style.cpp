// SPDX-License-Identifier: MIT
#include "watersky/products/detail/report_style.hpp"

#include "watersky/products/palette.hpp"

namespace watersky::detail {

namespace {

// The layers are switched by their inputs alone: the page has no script.
constexpr const char* kCss = R"css(
:root{--paper:#fff;--ground:#f3f5f7;--ink:#16202b;--soft:#5a6875;--line:#d5dce2;--card:#fff;--hatch:#e9e3d6;--hatch-line:#cfc5b0;--panel:#fffffff0;--count:#0072b2;--area:#e69f00;--third:#009e73;--grid:#101820}
@media (prefers-color-scheme:dark){:root{--paper:#10161d;--ground:#0b1015;--ink:#e6ecf1;--soft:#93a1ae;--line:#2a3540;--card:#151d26;--hatch:#332e26;--hatch-line:#4a4336;--panel:#10161de6;--count:#56b4e9;--area:#e69f00;--third:#009e73;--grid:#9fb4c6}}
@media print{:root{--paper:#fff;--ground:#fff;--ink:#000;--soft:#444;--line:#bbb;--card:#fff;--hatch:#e9e3d6;--hatch-line:#cfc5b0;--panel:#fffffff0;--count:#0072b2;--area:#e69f00;--third:#009e73;--grid:#101820}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;-webkit-print-color-adjust:exact;print-color-adjust:exact}
header{background:linear-gradient(180deg,#0a1a2e 0%,#14304c 45%,#41677f 82%,#9db9c4 100%);color:#f4f8fb;padding:2.2rem 0 2.9rem}
header>div{padding:0 1.2rem}
header>div,main,footer{max-width:1080px;margin:0 auto}
header h1{margin:.1rem 0 .5rem;font-size:2rem;line-height:1.15;font-weight:650;overflow-wrap:anywhere}
header p{margin:.1rem 0}
.kicker{text-transform:uppercase;letter-spacing:.12em;font-size:.78rem;opacity:.85}
main{padding:0 1.2rem}
section{background:var(--paper);border:1px solid var(--line);border-radius:10px;padding:1.1rem 1.3rem;margin:1.1rem 0}
h2{font-size:1.12rem;margin:0 0 .7rem}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(215px,1fr));gap:.7rem;margin:-1.3rem 0 0}
.card{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:.75rem .95rem}
.card dt{color:var(--soft);font-size:.82rem}
.card dd{margin:.1rem 0 0;font-size:1.45rem;font-weight:620;line-height:1.25;white-space:nowrap}
.card small{display:block;font-size:.78rem;font-weight:400;color:var(--soft);line-height:1.35;margin-top:.15rem;white-space:normal}
.sheet>input{position:absolute;opacity:0;pointer-events:none}
.switches{display:flex;flex-wrap:wrap;gap:.5rem 1.2rem;margin-bottom:.8rem}
.group{display:inline-flex;flex-wrap:wrap;gap:.3rem}
.switches label{border:1px solid var(--line);border-radius:999px;padding:.18rem .75rem;font-size:.86rem;cursor:pointer;color:var(--soft)}
figure{margin:0}
svg.map{display:block;width:100%;max-height:92vh;height:auto}
svg text{fill:var(--ink);font:13px system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
.unseen-ground{fill:var(--hatch)}.unseen-line{fill:var(--hatch-line)}
.base{display:none}
.neatline{fill:none;stroke:var(--ink);stroke-width:1.6}
.l-graticule path{fill:none;stroke:var(--grid);stroke-width:.8;stroke-opacity:.42}
.l-footprints path{fill:none;stroke:%FOOTPRINT%;stroke-width:1.1;stroke-opacity:.85;stroke-linejoin:round}
.l-track path{fill:none;stroke:%TRACK%;stroke-width:2.4;stroke-linejoin:round;stroke-linecap:round}
.l-track .halo{stroke:#fff;stroke-width:4.6;stroke-opacity:.65}
.l-track circle{fill:%TRACK%;stroke:#fff;stroke-width:.8}
.l-track .start{fill:#fff;stroke:%TRACK%;stroke-width:2.6}
.l-icebergs circle{fill:none;stroke:%ICEBERG%;stroke-width:2.8}
.l-icebergs text{fill:#5b1240;font-weight:700;paint-order:stroke;stroke:#fff;stroke-width:3px;stroke-linejoin:round}
.panel{fill:var(--panel);stroke:var(--line)}
.dark{fill:var(--ink);stroke:var(--ink)}.light{fill:var(--paper);stroke:var(--ink)}
.north text{font-weight:700}
figcaption,.keys{display:flex;flex-wrap:wrap;gap:.35rem 1.3rem;margin:.8rem 0 0;font-size:.86rem;color:var(--soft)}
.key{display:inline-flex;align-items:center;gap:.4rem}
.key b{color:var(--ink)}
.ramp{width:130px;height:13px;border:1px solid var(--line);border-radius:3px}
.swatch{width:20px;height:13px;border-radius:3px;display:inline-block}
.swatch.unseen{border:1px solid var(--line);background:repeating-linear-gradient(135deg,var(--hatch-line) 0 1.4px,var(--hatch) 1.4px 6px)}
.swatch.line{height:3px}.swatch.track{background:%TRACK%}.swatch.footprint{background:%FOOTPRINT%}
.swatch.ring{width:14px;height:14px;border-radius:50%;border:3px solid %ICEBERG%}
.by-count{fill:var(--count)}.by-area{fill:var(--area)}
.swatch.by-count{background:var(--count)}.swatch.by-area{background:var(--area)}
.chart{width:100%;max-width:760px;height:auto;display:block;margin:0 auto}
.chart .grid{stroke:var(--line)}.chart text{fill:var(--soft);font-size:12px}
.tone-a{--tone:var(--count)}.tone-b{--tone:var(--area)}.tone-c{--tone:var(--third)}
.chart .curve{fill:none;stroke:var(--tone);stroke-width:1.7;stroke-linejoin:round}.chart .band{fill:var(--tone);fill-opacity:.18}
.chart circle{fill:var(--tone);fill-opacity:.55}.swatch.line[class*=tone]{background:var(--tone)}
h3{font-size:.95rem;font-weight:600;margin:1.1rem 0 .4rem}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.88rem}
th,td{text-align:left;padding:.32rem .7rem .32rem 0;border-bottom:1px solid var(--line);vertical-align:top}
thead th{color:var(--soft);font-weight:550}
tbody td{white-space:nowrap}
.facts th{white-space:nowrap;font-weight:550;color:var(--soft)}.facts td{white-space:normal}
.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
.facts td.n{white-space:nowrap}
details{margin:.35rem 0}summary{cursor:pointer}
ul{margin:.2rem 0;padding-left:1.2rem}
.files{columns:16rem;font-size:.86rem;color:var(--soft)}
footer{padding:.4rem 1.2rem 2rem;color:var(--soft);font-size:.84rem}
@media (max-width:640px){svg.map text{font-size:23px}.chart text{font-size:19px}.map .scale,.map .north{display:none}header h1{font-size:1.5rem}section{padding:.9rem}main{padding:0 .6rem}header>div{padding:0 .9rem}.cards{grid-template-columns:1fr 1fr}.card dd{font-size:1.15rem}}
@media print{header{color:#000;background:none;padding:0 0 .5rem}.switches{display:none}section,.card{break-inside:avoid;border-color:#bbb}.cards{margin-top:.5rem}svg.map{max-height:none}.scroll{overflow:visible}}
)css";

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
}

}  // namespace

std::string report_css() {
  std::string css = kCss;
  for (const char* base : {"probability", "mosaic", "looks"}) {
    const std::string id = std::string("#b-") + base;
    css += id + ":checked~figure .l-" + base + "{display:inline}";
    css += id + ":not(:checked)~figure .k-" + base + "{display:none}";
    css += id + ":checked~.switches label[for=b-" + base + "]," + id +
           ":focus-visible~.switches label[for=b-" + base +
           "]{background:var(--ink);color:var(--paper);border-color:var(--ink)}";
  }
  for (const char* overlay : {"footprints", "track", "icebergs", "graticule"}) {
    const std::string id = std::string("#o-") + overlay;
    css += id + ":not(:checked)~figure .l-" + overlay + "{display:none}";
    css += id + ":checked~.switches label[for=o-" + overlay +
           "]{color:var(--ink);border-color:var(--ink)}";
    css += id + ":focus-visible~.switches label[for=o-" + overlay +
           "]{outline:2px solid var(--count)}";
  }
  replace_all(css, "%TRACK%", hex(kTrackColor));
  replace_all(css, "%FOOTPRINT%", hex(kFootprintColor));
  replace_all(css, "%ICEBERG%", hex(kIcebergColor));
  return css;
}

}  // namespace watersky::detail
