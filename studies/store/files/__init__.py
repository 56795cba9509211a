"""Files and locks that survive kills, full disks and links."""
