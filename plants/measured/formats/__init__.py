"""Files of a recorder, read into columns or channels: one format a file."""
