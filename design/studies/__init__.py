"""Studies: what was asked, plants and controllers, what they did, and the evidence, as values for pages."""
