"""What a trace ends with: the revised plant, what it names, and how much it leaves."""
