"""How each study is drawn: figures, findings and tables from stored data; the folders mirror `studies/definitions`."""
