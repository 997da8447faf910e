"""Controllers tuned under the whole requirement: PIs, LQI, MPC, and which of them is recommended."""
