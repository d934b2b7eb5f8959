"""Missions in XML, the format of BehaviorTree.CPP 4 that Groot 2 edits: read, and written."""
