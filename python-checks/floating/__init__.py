"""Random bodies that contact alone holds, each answer held against algorithms of another kind."""
