"""What all pages share: style, tables, names, HTML, and figures of more than one page."""
