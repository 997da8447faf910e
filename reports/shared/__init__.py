"""What all pages share: tables, names, HTML; `figures` for their style and those of more than one page."""
