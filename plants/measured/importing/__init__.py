"""From a recorder's files to a campaign: what each channel is, where the log is cut, what is held out."""
