//! How pages and plots look, in light and in dark, on screens of any width and on paper.

/// Okabe and Ito's colours, which all kinds of colour vision tell apart, lightened for dark paper where they need it:
/// (on light, on dark). The series of plots take them in turn; their shapes say the same again.
pub(super) const COLORS: [(&str, &str); 7] = [
    ("#0072b2", "#56b4e9"),
    ("#d55e00", "#ff8a3d"),
    ("#007a58", "#2bc79a"),
    ("#a8487f", "#e69ac4"),
    ("#8a6a00", "#e6b422"),
    ("#3b3bb3", "#a3a3ff"),
    ("#5f5f5f", "#bdbdbd"),
];

/// The colours of paper, ink and series: once for light, once for dark, light again for paper.
pub(super) fn variables() -> String {
    let series = |pick: fn(&(&'static str, &'static str)) -> &'static str| -> String {
        COLORS.iter().enumerate().map(|(i, colors)| format!("--s{i}:{};", pick(colors))).collect()
    };
    let light = format!(
        "--paper:#fff;--ink:#1c1e21;--soft:#5b6169;--grid:#e1e4e8;--minor:#f0f2f4;--zero:#eaf4ec;--line:#c8cdd3;\
         --shade:#f6f7f9;--bad:#b3261e;{}",
        series(|c| c.0)
    );
    let dark = format!(
        "--paper:#15171a;--ink:#e6e8eb;--soft:#a3abb5;--grid:#2c3137;--minor:#20242a;--zero:#17301f;--line:#454c55;\
         --shade:#1d2126;--bad:#ff8a80;{}",
        series(|c| c.1)
    );
    format!(
        ":root{{color-scheme:light dark;{light}}}\
         @media (prefers-color-scheme:dark){{:root{{{dark}}}}}\
         @media print{{:root{{color-scheme:light;{light}}}}}"
    )
}

/// The looks of what plots are made of.
pub(super) fn plot_rules() -> String {
    let series: String = (0..COLORS.len())
        .map(|i| format!(".mark.s{i}{{fill:var(--s{i})}}.label.s{i}{{fill:var(--s{i})}}.line.s{i},.spread.s{i},.fit.s{i},.mark.hollow.s{i}{{stroke:var(--s{i})}}"))
        .collect();
    format!(
        "svg text{{font:12px system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;fill:var(--ink)}}\
         .paper{{fill:var(--paper)}}.grid{{stroke:var(--grid)}}.minor{{stroke:var(--minor)}}.axis{{stroke:var(--soft)}}\
         .zero{{fill:var(--zero)}}svg .tick{{fill:var(--soft);font-size:11px;font-variant-numeric:tabular-nums}}\
         svg .name{{fill:var(--ink);font-size:12px}}svg .remark{{fill:var(--soft);font-size:11px}}\
         .mark{{stroke:var(--paper);stroke-width:1}}.mark.end{{fill:var(--soft)}}\
         \
         svg .label{{font-weight:600}}svg .label.end{{fill:var(--soft)}}\
         .line,.fit,.front{{fill:none;stroke-width:1.8}}.line.end{{stroke:var(--soft)}}.fit{{stroke-dasharray:5 4}}\
         .front{{stroke:var(--ink);stroke-width:1.2;stroke-dasharray:2 3}}.spread{{stroke-width:1.4;opacity:.65}}\
         .spread.end{{stroke:var(--soft)}}.leader{{stroke:var(--line)}}{series}\
         .mark.hollow{{fill:var(--paper);stroke-width:1.6}}.mark.hollow.end{{stroke:var(--soft)}}"
    )
}

/// The looks of pages.
pub(super) const PAGE_RULES: &str = "\
*{box-sizing:border-box}html{-webkit-text-size-adjust:100%}\
body{margin:0 auto;max-width:70rem;padding:1.25rem clamp(.9rem,3vw,2.5rem) 4rem;background:var(--paper);color:var(--ink);\
font:16px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;overflow-wrap:break-word}\
h1{font-size:1.9rem;line-height:1.2;margin:.6rem 0 .2rem}h2{font-size:1.4rem;line-height:1.25;margin:3rem 0 .4rem;padding-top:.8rem;border-top:1px solid var(--line)}\
h3{font-size:1.12rem;margin:2rem 0 .3rem}p,ul,dl{max-width:44rem;margin:.5rem 0}a{color:var(--s0)}\
.facts{color:var(--soft)}.nav{display:flex;flex-wrap:wrap;gap:.3rem 1.1rem;padding:0;margin:.9rem 0;list-style:none}\
dt{font-weight:600;margin-top:.5rem}dd{margin:0 0 0 1.1rem}\
figure{margin:1rem 0;min-width:0}figcaption{color:var(--soft);font-size:.88rem;max-width:44rem}\
.scroll{overflow-x:auto;-webkit-overflow-scrolling:touch}.scroll:focus-visible{outline:2px solid var(--s0)}\
.plot svg{display:block;width:100%;height:auto}.plot.large svg{min-width:30rem;max-width:46rem}.plot.lines svg{min-width:22rem}\
.grid2{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,25rem),1fr));gap:0 2rem}\
.grid3{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,17.5rem),1fr));gap:0 1.5rem}\
table{border-collapse:collapse;font-size:.88rem;margin:.4rem 0}caption{text-align:left;color:var(--soft);padding:.2rem 0}\
th,td{padding:.28rem .7rem .28rem 0;text-align:left;vertical-align:top;border-bottom:1px solid var(--grid)}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}th{font-weight:600;border-bottom-color:var(--line);white-space:nowrap}\
td:first-child{white-space:nowrap}td.why{min-width:18rem}.bad{color:var(--bad)}.soft{color:var(--soft)}\
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,16rem),1fr));gap:.6rem}.pictures figure{margin:.3rem 0}\
img{display:block;width:100%;height:auto;border-radius:3px;background:var(--shade)}\
details{margin:.5rem 0;border-left:3px solid var(--line);padding-left:.8rem}summary{cursor:pointer;font-weight:600}\
pre{overflow-x:auto;font:12px/1.45 ui-monospace,'DejaVu Sans Mono',Consolas,monospace;background:var(--shade);padding:.7rem;margin:.4rem 0}\
code{font:.9em ui-monospace,'DejaVu Sans Mono',Consolas,monospace}\
@media print{body{max-width:none;padding:0;font-size:10.5pt}.nav{display:none}figure,tr,h2,h3{break-inside:avoid}h2,h3{break-after:avoid}\
.scroll{overflow:visible}.plot svg{min-width:0!important}table{font-size:7.5pt}th,td{padding-right:.3rem}td.why{min-width:0}pre{white-space:pre-wrap;font-size:7pt}}";

/// The style of a plot in a file of its own.
pub(super) fn standalone() -> String {
    variables() + &plot_rules()
}
