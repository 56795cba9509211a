"""How each study is drawn: figures, findings and tables from stored data; see `studies.registry`."""
