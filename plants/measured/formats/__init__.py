"""Reading files of any known format: columns by name, their units, and a campaign file to start from."""
