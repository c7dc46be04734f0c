"""Holds the style sheet of the report. The report embeds it and needs no other file."""

CSS = """
body { font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: #1b1f24; background: #fff;
  margin: 0 auto; max-width: 1240px; padding: 1.5rem }
h1 { font-size: 1.7rem; margin: 0 0 .6rem }
h2 { font-size: 1.25rem; margin: 2.4rem 0 .4rem; border-bottom: 1px solid #d5d9de }
p { max-width: 75ch; margin: .5rem 0 }
small { color: #4a5058; white-space: normal }
dl { display: flex; flex-wrap: wrap; gap: .4rem 2.2rem; margin: .8rem 0 }
dt { color: #4a5058; font-size: .85rem }
dd { margin: 0; font-weight: 600 }
figure { margin: .6rem 0 }
img { width: 100%; height: auto }
figcaption { max-width: 85ch; color: #33383e; font-size: .92rem }
.wide { overflow-x: auto }
.side { display: flex; flex-wrap: wrap; gap: 0 3rem }
table { border-collapse: collapse; font-size: .86rem; font-variant-numeric: tabular-nums; margin: .6rem 0 }
caption { text-align: left; font-weight: 600; padding: .3rem 0 }
th, td { padding: .22rem .6rem; border-bottom: 1px solid #e4e7ea; text-align: left; vertical-align: top }
th { background: #f2f4f6 }
.right { color: #00527f; font-weight: 700; white-space: nowrap }
.wrong { color: #a63c00; font-weight: 700; white-space: nowrap }
.fault { color: #a63c00; font-weight: 700 }
.no-answer { color: #4a5058; white-space: nowrap }
.bar { display: inline-block; height: .7em; background: #0072B2 }
h3 { font-size: 1.05rem; margin: 1.2rem 0 .3rem }
.signed figure { max-width: 900px }
.body-mark { float: right; width: 4.5rem; margin-left: 1rem }
.maps { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 22rem), 1fr)); gap: .4rem 1.6rem }
.line { border-bottom: 1px solid #1b1f24; height: 2.4rem; color: #4a5058; font-size: .85rem }
.signatures { display: grid; grid-template-columns: 2fr 1fr 2fr; gap: 2rem; margin-top: 1rem }
.annex { margin-top: 2.4rem }
.annex > summary { font-size: 1.25rem; font-weight: 600; cursor: pointer }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); gap: 1rem;
  align-items: start }
.withdrawn { color: #4a5058 }
.note { white-space: pre-wrap; overflow-wrap: anywhere; unicode-bidi: isolate }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .75rem }
h1, dd, td, th, p, figcaption { overflow-wrap: break-word }
.hash { overflow-wrap: anywhere }
.value { white-space: nowrap }
@page { size: A4 portrait; margin: 13mm 12mm }
@media print {
  body { font-size: 9.5pt; line-height: 1.35; padding: 0; max-width: none }
  h1 { font-size: 15pt }
  h2 { margin-top: 1.2rem }
  h3 { margin-top: .7rem }
  p, figcaption { max-width: none }
  figcaption { font-size: 8pt }
  .line { height: 1.9rem }
  table { font-size: 7.5pt }
  th, td { padding: .15rem .35rem }
  th { background: none }
  .signed img { max-height: 75mm; width: auto; max-width: 100% }
  .next, .annex { break-before: page }
  .maps, .pair { grid-template-columns: 1fr 1fr }
  .maps img { max-height: 62mm; width: auto; max-width: 100% }
  .finding > * { margin: .2rem 0 }
  .finding img { max-height: 48mm; width: auto; max-width: 100% }
  .finding, figure, table, tr { break-inside: avoid }
  h2, h3 { break-after: avoid }
  .screen, .annex:not([open]) { display: none }
}
"""
