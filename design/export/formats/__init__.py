"""What an export is written as: a folder of C, functional mock-up units, structured text."""
