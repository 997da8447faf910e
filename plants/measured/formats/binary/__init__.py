"""Logs in containers of their own: MDF4, TDMS, HDF5, MATLAB, ROS bags."""
