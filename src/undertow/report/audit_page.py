def write_audit(findings, folder, config):
    pass
