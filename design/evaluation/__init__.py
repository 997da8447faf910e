"""How designs are evaluated: the study of controllers, and what figures of plants and loops rest on."""
