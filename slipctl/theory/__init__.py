"""The paper's mathematics as functions of arrays: no engine, no files."""
