"""Messages of ROS as dataclasses, with the fields that this package reads or writes.

Names of classes and fields are those of the official definitions; `bendtwin_ros.convert` turns
one into the other. A field that is not here keeps its default on the wire.
"""
