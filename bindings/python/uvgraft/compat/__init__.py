"""The functions of other tools, done by uvgraft: scripts run after a change of one import."""
