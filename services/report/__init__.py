"""The page that shows a rebuild: one self-contained HTML file with pictures."""
