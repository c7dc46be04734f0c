// Colours of the tactile map, made by `python -m operator_site.console.map.colours` out of that module.
// vik, batlow, bilbao: copyright 2020 Fabio Crameri, MIT licence, see colours-licence.txt.
const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
// A table is sent as every 5th colour; the others lie between.
const table = text => {
  const few = bytes(text);
  return Uint8Array.from({ length: 768 }, (_, at) => {
    const low = at % 3 + 3 * Math.floor(at / 15);
    const share = Math.floor(at / 3) % 5 / 5;
    return Math.round(few[low] + share * ((few[low + 3] ?? 0) - few[low]));
  });
};

/** 256 colours of each scale from low to high: red, green, blue. */
export const TABLES = {
  temperature: table("ABJhARpmAiJrAipwAjF1Ajl6A0F/A0mEBVGJCFmPEGKUGWuaJXWhM3+oQomvUZS2YZ69cajEgLLKkLzRoMXYsM/ewNjkz+Do3ubp6Ofl7uPc7tvQ7NHD6Mi15L6o37Sa26qN16CB05d0z45ozIVdyHxRxHRFwGs6vGIvtlgkr0wYpUAPmjUIjysGhSIGfBsGcxQGag0HYgYHWQAI"),
  roughness: table("ARlZBiFbCihcDC9dDjZeDzxfEUFgEkZhE0thFU9iGFRiG1hiHl1iI2BgKGRfL2dcNWpZPG1WRHBSTHJNU3VJW3dFY3pAbHw8dH44fYE0hoMwj4YtmYgso4osrYwtt44xwJA2ypI80pND25VL45dU6ple8Jxp9Z90+aOA+6aM/aqX/a6i/bKt/bW4/bnC/bzN/MDY/MTj+8jv+sz6"),
  stiffness: table("////9vb27e3t5eXk3d3b1tXT0M/LzMrDyce8x8O0xcGtw76mwbuev7eVvLSNurCDt6x6tadys6FrsZxnr5dkrpNirI9hq4tgqodfqYRfqIBep3xdpnlcpXVbpHFbo25aompZoWZYoGJXn15WnllVnFRTmU9RlklOkkNKjT1FiDg/gjI5fC0ydicscCEmaRsfYhUZWw4TVAcLTAAB"),
};
/** Of the first four materials, and of all others. */
export const MATERIALS = bytes("H1+o8rE0j9DAiy9fbXaA");
/** Of unexplored cells. */
export const BACKGROUND = bytes("gIiQ");
/** Opacity over that by confidence, 0..3. */
export const OPACITY = [0.0, 0.5, 0.75, 1.0];
