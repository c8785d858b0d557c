"""The pictures of a trial, as text of SVG: `headline`, `power`, `cost`, `cases`."""
